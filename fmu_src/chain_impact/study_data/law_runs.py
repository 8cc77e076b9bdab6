"""The results of contact laws that are compared, without the text and the picture of the comparison."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from chain_impact.deprecated import OlderName
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.recording.equality import have_equal_fields
from chain_impact.recording.joint_stops import is_scene_joint_stop
from chain_impact.recording.recording import Recording
from chain_impact.scene.keys.tables import Contact
from chain_impact.scene.scene import Scene
from chain_impact.study_data.compared_impact import contact_at, first_number

# An impact is free if its restitution without losses differs from 1, and its restitution with the exact law
# from e, by at most FREE_TOLERANCE. If a realised restitution exceeds 1 by more than this, other forces drive
# the contact apart.
FREE_TOLERANCE = 0.05


@dataclass(frozen=True, eq=False)
class LawRecording:
    """The recording of a scene with one contact law, and the values of the first impact; see ``LawRun``."""

    __eq__ = have_equal_fields
    __hash__ = None  # type: ignore[assignment]

    law: str
    exponent: float
    stiffness: float
    restitution: float = math.nan
    peak_force: float = math.nan
    max_penetration: float = math.nan
    duration: float = math.nan
    energy_lost: float = math.nan
    loop: np.ndarray | None = field(default=None, repr=False)
    divergence: int | None = None
    divergence_time: float = math.nan
    note: str = ""
    result: Recording | None = field(default=None, repr=False)


LawRunType_co = TypeVar("LawRunType_co", bound=LawRecording, covariant=True)


@dataclass(frozen=True)
class ReachedRestitutions:
    """The realised restitutions of the first impact at one stiffness; NaN if a restitution is unknown.

    Attributes:
        stiffness: stiffness K of the contact [N/m^n]; at a stop of a joint [N·m/rad^n].
        lossless: restitution with the law without losses, about the largest possible restitution; about 1 in
            a free impact.
        exact: restitution with the exact law; about the prescribed restitution in a free impact.
    """

    stiffness: float
    lossless: float
    exact: float


@dataclass(frozen=True, eq=False)
class LawRuns(Generic[LawRunType_co]):
    """The runs of one scene with several laws; ``Comparison`` (studies/compare) describes the attributes."""

    __eq__ = have_equal_fields
    __hash__ = None  # type: ignore[assignment]

    scene: Scene
    reference: str
    runs: tuple[LawRunType_co, ...]
    reached: tuple[ReachedRestitutions, ...]

    def __getitem__(self, law: str) -> LawRunType_co:
        """Return the run with a law, by the law's id."""
        return next(run for run in self.runs if run.law == law)

    @property
    def first_impact(self) -> np.void:
        """The first impact with the reference law, a row of ``Result.impacts``.

        If stops have their own law, this is the first impact at a wall.
        """
        impact = first_of(self.scene, self[self.reference].result)
        assert impact is not None  # ``compare`` refuses a scene without this impact
        return impact

    @property
    def contact(self) -> Contact:
        """The scene's contact with the values of the first impact's wall or of [stops] (``contact_at``)."""
        return contact_at(self.scene, self.first_impact)

    @property
    def is_free(self) -> bool:
        """Whether the first impact is free: other forces than those of the contact hardly change it.

        The impact counts as free unless the realised restitution without losses differs from 1, or that with
        the exact law from the prescribed restitution, by more than FREE_TOLERANCE. A realised restitution
        that is unknown, such as that of an impact that does not end in the run, does not count.
        """
        reached_pair = self.reached[0]
        deviations = (abs(reached_pair.lossless - 1.0), abs(reached_pair.exact - self.contact.restitution))
        return not any(deviation > FREE_TOLERANCE for deviation in deviations)

    @property
    def pressed_again(self) -> bool:
        """Whether under any law the penetration in the first impact grows again after it has fallen.

        Then other forces than that of the contact press the contact again before it ends.
        """
        return any(run.loop is not None and grows_again(run.loop) for run in self.runs)

    @property
    def no_restitution(self) -> str:
        """The reason why the restitutions e′ of the first impact do not describe the contact alone, or ""."""
        if self.pressed_again:
            return "other forces push on during this contact, so it has no restitution e′"
        if not self.first_impact["impact_speed"]:
            return "this contact begins without a speed"
        largest_restitution = max(np.nan_to_num([run.restitution for run in self.runs]), default=0.0)
        return "other forces drive this contact apart" if largest_restitution > 1.0 + FREE_TOLERANCE else ""

    @property
    def has_restitution(self) -> bool:
        """Whether the restitutions e′ of the first impact describe the contact alone (``no_restitution``)."""
        return not self.no_restitution

    at_stop = OlderName("is_at_stop")

    @property
    def is_at_stop(self) -> bool:
        """Whether ``first_impact`` is at a stop of a joint: moment and angle replace force and length."""
        return is_scene_joint_stop(self.scene, self.first_impact["wall"])


def grows_again(loop: np.ndarray) -> bool:
    """Return whether the penetration of a loop grows again after it has fallen; see ``LawRun.loop``."""
    return bool(np.count_nonzero(np.diff(np.diff(loop[0]) > 0.0)) > 1)


def first_of(scene: Scene, recording: Recording | None) -> np.void | None:
    """Return the first impact that obeys ``contact.model`` (``first_number``), a row of ``Result.impacts``.

    Without a recording or such an impact, None is returned.
    """
    number = None if recording is None else first_number(scene, recording.impacts)
    return None if recording is None or number is None else recording.impacts[number]


def has_jump(law: str) -> bool:
    """Return whether the force of a law jumps at the onset if e < 1; False for a law from a user's file."""
    return law in CONTACT_LAWS and CONTACT_LAWS[law].rate_exponent == 0.0


def with_jump(law: str, loop: np.ndarray) -> np.ndarray:
    """Return a loop with the force just after the onset, so that a jump of the force is vertical.

    This force is on the straight line through the first two points with a penetration. A loop of a law
    without a jump (``has_jump``) is returned unchanged.
    """
    if not has_jump(law):
        return loop
    first = int((loop[0] > 0.0).argmax())
    (depth, next_depth), (force, next_force) = loop[:, first : first + 2]
    onset = force - depth * (next_force - force) / (next_depth - depth)
    return np.insert(loop, first, (0.0, onset), axis=1)
