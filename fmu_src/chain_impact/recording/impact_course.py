"""The course (history) of one impact: force, penetration and speed over time, also between two rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np

from chain_impact.progress import Progress
from chain_impact.recording.joint_stops import is_scene_joint_stop
from chain_impact.recording.pacing import impact_ends
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.texts.names import STOPS
from chain_impact.variables.prepared import PreparedScene

# number of equally spaced times at which the course of an impact is computed; a contact that lasts beyond the
# end that ``impact_ends`` gives has more
COURSE_SAMPLES = 400
# number of equally spaced times over the whole of such a long contact
LASTING_SAMPLES = 4000
# [1] the first of COURSE_SAMPLES times after the onset in geometric progression, relative to the duration of
# a contact that lasts beyond the end that ``impact_ends`` gives
FIRST_SAMPLE = 1e-6


class RepeatableRun(Protocol):
    """A run that can be repeated, with rows at other times."""

    @property
    def prepared_scene(self) -> PreparedScene:
        """The scene of the run, prepared."""

    def __call__(self, times: np.ndarray, progress: Progress = ...) -> np.ndarray:
        """Return the outputs at increasing times [s], shape (S,).

        The function ``progress`` is called with the finished fraction, 0 to 1.

        The result is a structured array with one row for each time, or fewer rows if the run ends early.
        """

    def inputs(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """Return name of each input that the caller gives over time → values at increasing times [s]."""

    def series(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """Return name → values, at increasing times [s], of inputs and of outputs that change continuously.

        There are fewer values than times if the run ends early.
        """

    def changed(self, values: Mapping[str, Any]) -> Self:
        """Return the run with the same inputs over time and with other values of parameters.

        Raises:
            SceneError: when the scene cannot have one of the values, or a name is not that of a parameter.
        """


@dataclass(frozen=True, eq=False)
class ImpactCourse:
    """One impact over time. At a stop of a joint, moment [N·m] and angle [rad] replace force and length.

    Attributes:
        time: times of the run, from the onset to the end of the impact, shape (S,) [s]; empty for an impulse
            of a rigid wall.
        force: the normal force of the wall at each time, shape (S,) [N].
        penetration: the penetration at each time, shape (S,) [m].
        speed: the rate of penetration at each time, positive during compression, shape (S,) [m/s].
        energy_lost: the energy [J] that the whole chain dissipates from just before the onset until just
            after the end.
    """

    time: np.ndarray
    force: np.ndarray
    penetration: np.ndarray
    speed: np.ndarray
    energy_lost: float


@runtime_checkable
class HasRerun(Protocol):
    """A recording that computes the courses of its impacts if its run can be repeated."""

    @property
    def rerun(self) -> RepeatableRun | None:
        """The run, to repeat it; None if the run cannot be repeated."""

    def course_of_impact(self, number: int) -> ImpactCourse:
        """Return the course of an impact, by its number from 1.

        Raises:
            ValueError: when the impact does not exist, or the run cannot be repeated.
        """


def course_of(
    prepared_scene: PreparedScene,
    rerun: RepeatableRun | None,
    impact: np.void,
    *,
    end_time: float = math.nan,
) -> ImpactCourse:
    """Return the course of one impact.

    The run is repeated up to the end of the impact, with additional rows within the impact. The repeated run
    is identical bit by bit, because additional rows do not change the solution. If the contact lasts beyond
    the end that ``impact_ends`` gives, more samples lie just after the onset, and from the onset to that end.

    Args:
        prepared_scene: the prepared scene.
        rerun: ``Result.rerun``.
        impact: the impact, a row of ``Result.impacts``.
        end_time: the end of the course [s] for a contact whose end is NaN.

    Raises:
        ValueError: when the run of the result cannot be repeated.
    """
    if rerun is None:
        raise ValueError(
            f"{prepared_scene.scene.name}: only a result of simulate() has the course of an impact"
        )
    onset, end = float(impact["onset"]), float(impact["end"])
    end = end_time if math.isnan(end) else end
    contact_times = np.linspace(onset, end, COURSE_SAMPLES if end > onset else 0)
    duration = float(impact_ends(np.array([impact], impact.dtype), end)[0]) - onset
    if 0.0 < duration < end - onset:
        shares = np.union1d(
            np.geomspace(FIRST_SAMPLE, 1.0, COURSE_SAMPLES), np.linspace(0.0, 1.0, LASTING_SAMPLES)
        )
        times = np.union1d((end - onset) * shares, np.linspace(0.0, duration, COURSE_SAMPLES))
        contact_times = np.unique((onset + times).clip(onset, end))
    start_limit, end_limit = max(0.0, math.nextafter(onset, 0.0)), math.nextafter(end, math.inf)
    outputs = rerun(np.concatenate([[start_limit], contact_times, [end_limit]]))
    output_index, sign = contact_output(prepared_scene, impact)
    contact_values = outputs[1 : 1 + len(contact_times)]
    speed = contact_values["penetration_rate"][:, output_index].copy()
    # The output ``penetration_rate`` is 0 at onset and end, because the penetration is 0 there. The impact
    # speed and, if the contact has ended, the separation speed in the list of impacts replace these values.
    if len(speed):
        speed[0] = impact["impact_speed"]
    if len(speed) == len(contact_times) > 1 and not math.isnan(impact["end"]):
        speed[-1] = -impact["separation_speed"]
    return ImpactCourse(
        time=contact_times[: len(contact_values)],
        force=(sign * contact_values["force"][:, output_index]).clip(0.0),
        penetration=contact_values["penetration"][:, output_index].clip(0.0),
        speed=speed,
        energy_lost=float(outputs["dissipated"][-1] - outputs["dissipated"][0]),
    )


def contact_output(prepared_scene: PreparedScene, impact: np.void) -> tuple[int, float]:
    """Return the index of an impact's contact among the outputs of contacts, and the sign of its force there.

    The sign is −1 at ``joint_max``, and 1 otherwise. Both stops of a joint share one output: their moment,
    which is positive at ``joint_min`` and negative at ``joint_max``.
    """
    pairs, scene = prepared_scene.candidates, prepared_scene.scene
    if not is_scene_joint_stop(scene, impact["wall"]):
        return pairs.index((impact["point"], impact["wall"])), 1.0
    first = len(point_wall_pairs(scene))
    of_joint = [joint for joint, _ in pairs[first:]].index(impact["point"])
    return first + of_joint, 1.0 if scene.wall_names[impact["wall"]] == STOPS[0] else -1.0
