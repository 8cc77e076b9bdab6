"""The run of a data set with the fitted values, in the rows that a picture needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chain_impact.progress import no_progress
from chain_impact.results.result import Result
from chain_impact.simulation.given_inputs import NamedInputs
from chain_impact.simulation.held_motions import holds_motions
from chain_impact.simulation.input_schedule import input_schedule
from chain_impact.simulation.run import Run
from chain_impact.studies.fit.estimates import Estimates
from chain_impact.variables.prepared import PreparedScene

CURVE_POINTS = 1500  # number of equal intervals of time between the rows of a run


def model_run(fit: Estimates, k: int) -> Result:
    """Return the run of data set ``k`` with the fitted values, in CURVE_POINTS + 1 rows of equal distance.

    If the run stops at a fault, it has only the rows before.
    Inputs act as in the fit, between the times of the data set.
    """
    data, scene = fit.data[k], fit.scenes[k]
    stop_time = max(1e-9, data.end(scene.simulation.stop_time))
    inputs = dict(data.inputs) | {
        parameter.name: fit.values[parameter.label]
        for parameter in fit.parameters
        if parameter.name not in scene.values and parameter.data_set in (None, k)
    }
    prepared_scene = PreparedScene(scene.with_values({"simulation.stop_time": stop_time}))
    points = np.union1d(data.times[data.times < stop_time], [0.0, stop_time])
    schedule = input_schedule(prepared_scene, NamedInputs(inputs, data.interpolation), points)
    times = np.linspace(0.0, stop_time, CURVE_POINTS + 1)
    is_held = holds_motions(schedule)  # then rows between the communication points need a second run
    run_schedule = schedule if is_held else schedule.with_times(times)
    run = Run(prepared_scene, (), run_schedule, prepared_scene.output_indices)
    run.execute(no_progress)
    result = run.result((), None)
    if not is_held:
        return result
    assert result.rerun is not None  # only a stored result lacks it
    outputs = result.rerun(times)
    return replace(result, time=times[: len(outputs)], outputs=outputs, stepwise={})
