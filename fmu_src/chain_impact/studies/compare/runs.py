"""The run of a scene with one of the contact laws that are compared."""

from __future__ import annotations

from dataclasses import dataclass, field

from chain_impact.results.result import Result
from chain_impact.study_data.law_runs import LawRecording


@dataclass(frozen=True, eq=False)
class LawRun(LawRecording):
    """The run of a scene with one contact law, and the values of the first impact.

    The first impact is the first one at a wall if stops have their own law, else the first one of all.
    Without a first impact, its values are NaN. If the first impact is no impulse, and lasts to the end of the
    run, peak force and penetration are the largest up to this end, and its other values are NaN. At a stop of
    a joint, a moment [N·m] and an angle [rad] replace force and penetration.

    Attributes:
        law: the id of the law.
        exponent: exponent n at the wall or stop of the first impact; without a first impact, that of the
            scene, or the exponent that the law needs.
        stiffness: stiffness K that belongs to ``exponent`` [N/m^n]; at a stop of a joint [N·m/rad^n].
        restitution: the realised restitution of the first impact.
        peak_force: peak force of the first impact [N]; 0 for an impulse.
        max_penetration: largest penetration in the first impact [m].
        duration: duration of the first impact [s]; 0 for an impulse.
        energy_lost: energy that the whole chain dissipates from the onset to the end of the first impact [J].
        loop: penetration [m] and force [N] in the first impact, shape (2, S); empty for an impulse; None
            without a first impact, or if it lasts to the end of the run.
        divergence: number, from 1, of the first impact whose point or wall differs from that of the impact
            with this number under the reference law, or that only one of the two runs has; impacts that a run
            lacks because it ended early do not count. None without such an impact.
        divergence_time: onset of the impact with the number ``divergence`` [s]; NaN without such an impact.
        note: the reason why the result is missing or incomplete, or a remark; "" without both.
        result: the result of the run, up to a fault; None if the run could not start.
    """

    result: Result | None = field(default=None, repr=False)

    @property
    def impacts(self) -> int:
        """The number of impacts in the run; 0 without a result."""
        return len(self.result.impacts) if self.result else 0

    @property
    def steps(self) -> int:
        """The number of steps that the solver took in the run; 0 without a result."""
        return self.result.statistics["steps"] if self.result else 0

    @property
    def evaluations(self) -> int:
        """The number of evaluations of the equations of motion in the run; 0 without a result."""
        return self.result.statistics["rhs_evaluations"] if self.result else 0
