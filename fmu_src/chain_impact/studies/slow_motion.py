"""A recording for an animation: with rows so close in time that each impact can be seen slowly."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chain_impact.progress import Progress, silent
from chain_impact.results.animation.contacts import slow_spans
from chain_impact.results.animation.pacing import IMPACT_TIME, frame_times
from chain_impact.results.recording import Recording
from chain_impact.results.result import Result, recording_of
from chain_impact.scene.scene import SceneSource, scene_of
from chain_impact.simulation.inputs import Signal, drive
from chain_impact.simulation.instance import Instance, WordRows, structured
from chain_impact.simulation.simulate import simulate

MOST_ROWS = 40_000
WITHIN = np.linspace(
    0.0, 1.0, 25
)  # of an impact that is too weak to be shown slowly: rows for its peak force
LONGEST_IMPACT = 5.0  # of penetration over approach speed
SLOWEST = 1e-6  # m/s, approach speed of a point that comes to rest at a wall


def record_slowly(
    scene: SceneSource,
    impact_time: float = IMPACT_TIME,
    progress: Progress | None = None,
    *,
    inputs: Mapping[str, Signal] | None = None,
) -> Recording:
    """Simulate a scene twice: to find the impacts, and with rows that are close in time around them.

    The rows do not change the solution.

    Args:
        scene: what to simulate: a scene, or what ``load_scene`` takes.
        impact_time: what each impact takes on the screen [s], 0 for no slow motion.
        progress: called with the fraction done, if given.
        inputs: as for ``simulate``.

    Raises:
        SceneError: when an input cannot be one.
        SimulationError: when the solver cannot go on; it holds the result up to there, with even rows.
        BuildError: when the kernel cannot be compiled.
    """
    scene, show = scene_of(scene), progress or silent
    result = simulate(scene, inputs=inputs, progress=lambda done: show(done / 2))
    stop = float(result.time[-1])
    onsets, speeds = result.impacts["onset"], result.impacts["impact_speed"]
    # an impact takes 2.9 δ/v by Hertz, π δ/v at a linear spring, and longer with losses; then the chain stays
    lasting = LONGEST_IMPACT * result.impacts["max_penetration"] / np.maximum(speeds, SLOWEST)
    ends = np.fmin(result.impacts["end"], np.minimum(onsets + lasting, stop))
    compared = [impact.end_speed for impact in recording_of(result).impacts]
    spans = slow_spans([((float(a), float(b)), v) for a, b, v in zip(onsets, ends, compared, strict=True)])
    shown, _ = frame_times(0.0, stop, spans, impact_time, MOST_ROWS)
    others = (onsets[:, None] + (ends - onsets)[:, None] * WITHIN).ravel()[:MOST_ROWS]
    driven = drive(result.model, inputs or {}, "follow", np.union1d(shown, others.clip(0.0, stop)))
    instance = Instance(result.model, driven)
    rows = WordRows(len(driven.times), result.model.output_words)
    done, _ = instance.run(driven, rows, lambda part: show(0.5 + part / 2))
    return recording_of(
        Result(
            result.model,
            driven.times[:done],
            structured(rows.numbers[:done], result.model.row),
            result.impacts,
            statistics=instance.statistics,
            stick_slip=result.stick_slip,
        )
    )
