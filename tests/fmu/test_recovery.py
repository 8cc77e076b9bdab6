"""No importer loses an impact: at any step, each importer recovers the list of simulate()."""

# Tests: fmu/build.py, recording/impacts.py

import numpy as np
import pytest

from chain_impact import impacts_of, load_scene, simulate
from chain_impact.fmu.build import build_fmu
from tests.fmu.scenes import KINDS
from tests.helpers.campaigns.random_scenes import scene as random_scene

of_each = pytest.mark.parametrize(
    ("model", "size"),
    [(model, size) for model in ("four_link_box", "rod_drop") for size in (1e-3, 1e-2, 0.1)],
)


@pytest.fixture(scope="module")
def expected():
    return {model: simulate(load_scene(model)) for model in ("four_link_box", "rod_drop")}


def recorded(fmu, size, events=False, stop=None):
    """Return the columns of time, impacts and solver from fmpy's own loop in the clean process."""
    import fmpy

    modes = {"use_event_mode": True, "early_return_allowed": True} if events else {}
    names = [v.name for v in fmpy.read_model_description(fmu).modelVariables if v.causality == "output"]
    names = [name for name in names if name.startswith(("impact", "solver"))]
    rows = fmpy.simulate_fmu(fmu, output_interval=size, output=names, stop_time=stop, **modes)
    return {name: rows[name].tolist() for name in rows.dtype.names}


def table(record):
    return impacts_of({name: np.array(column) for name, column in record.items()})


def assert_recovered(record, impacts):
    """Assert equal onsets, points, walls and impact speeds, and all else within small errors."""
    recovered = table(record)
    assert len(recovered) == len(impacts)
    for name in ("onset", "point", "wall", "impact_speed"):
        np.testing.assert_array_equal(recovered[name], impacts[name], err_msg=name)
    for name in ("end", "separation_speed"):
        np.testing.assert_allclose(recovered[name], impacts[name], rtol=0, atol=1e-9, err_msg=name)
    for name in ("peak_force", "max_penetration", "impulse"):
        np.testing.assert_allclose(recovered[name], impacts[name], rtol=1e-6, err_msg=name)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(
    ("kind", "seed", "stop"),
    [("pythonfmu", 9000359, 0.125), ("native", 9000193, 0.25), ("fmi3", 8000264, 0.0625)],
)
def test_impacts_do_not_depend_on_the_communication_step(kind, tmp_path, clean, seed, stop):
    """The model has dry friction, stops and rigid walls.

    The times are binary fractions, exact at every step.
    """
    scene = random_scene(seed).with_values({"outputs.impacts": 16})
    fmu = str(build_fmu(scene, tmp_path, **KINDS[kind]))
    records = [clean(recorded, fmu, stop / steps, False, stop) for steps in (1, 64, 1024)]
    first, *other_outputs = ({name: column[-1] for name, column in record.items()} for record in records)
    np.testing.assert_equal(other_outputs, [first, first])


@pytest.mark.full("more cases", but=3)
@of_each
def test_fmpy_in_event_mode_sees_every_impact_whatever_the_step(all_fmus, clean, expected, model, size):
    record, impacts = clean(recorded, all_fmus["fmi3"][model], size, True), expected[model].impacts
    assert_recovered(record, impacts)
    # fmpy records the time of an event twice: before and after the impact
    times, counts = np.array(record["time"]), np.array(record["impact.count"])
    twice = times[1:][(np.diff(times) == 0.0) & (np.diff(counts) > 0)]
    np.testing.assert_array_equal(twice, np.unique(impacts["onset"]))
