"""No importer loses an impact: what each sees of them, at any step, is the list of simulate()."""

import subprocess

import numpy as np
import pytest

from chain_impact import impacts_of, load_scene, simulate
from chain_impact.compilation.compilers import INCLUDES
from tests.fmu.contents import description
from tests.fmu.interface import unpacked
from tests.fmu.zig import WARNINGS, zig

SIZES = [1e-3, 1e-2, 0.1]  # s
MODELS = ["four_link_box", "rod_drop"]
LATEST = 8  # impacts that an FMU shows


@pytest.fixture(scope="module")
def expected():
    return {model: simulate(load_scene(model)) for model in MODELS}


# The functions before each test run in the clean process: they hold all that they use.


def recorded(fmu, size, events):
    """fmpy's own loop; the columns that have to do with impacts."""
    import fmpy

    modes = {"use_event_mode": True, "early_return_allowed": True} if events else {}
    names = [v.name for v in fmpy.read_model_description(fmu).modelVariables if v.causality == "output"]
    names = [name for name in names if name.startswith("impact")]
    rows = fmpy.simulate_fmu(fmu, output_interval=size, output=names, **modes)
    return {name: rows[name].tolist() for name in rows.dtype.names}


def assert_recovered(record, impacts):
    """Onsets, points and walls equal; peaks and impulses as good as they can be seen."""
    found = impacts_of({name: np.array(column) for name, column in record.items()})
    assert len(found) == len(impacts)
    for name in ("onset", "point", "wall", "impact_speed"):
        np.testing.assert_array_equal(found[name], impacts[name], err_msg=name)
    for name in ("end", "separation_speed"):
        np.testing.assert_allclose(found[name], impacts[name], rtol=0, atol=1e-9, err_msg=name)
    for name in ("peak_force", "max_penetration", "impulse"):
        np.testing.assert_allclose(found[name], impacts[name], rtol=1e-6, err_msg=name)


@pytest.mark.full("more cases", but=17)
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("model", MODELS)
def test_fmpy_sees_every_impact(fmus, clean, expected, model, size):
    """From impact[j].* alone, where no more come in a step than are shown."""
    record, impacts = clean(recorded, fmus[model], size, False), expected[model].impacts
    if max(np.diff(record["impact.count"])) <= LATEST:
        assert_recovered(record, impacts)
    else:
        assert (model, size) == ("rod_drop", 0.1)
        assert len(impacts_of(record)) < len(impacts) == record["impact.count"][-1]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("model", MODELS)
def test_fmpy_in_event_mode_sees_every_impact_whatever_the_step(all_fmus, clean, expected, model, size):
    record, impacts = clean(recorded, all_fmus["fmi3"][model], size, True), expected[model].impacts
    assert_recovered(record, impacts)
    # at an event fmpy records the time twice: before the impact, and after it
    times, counts = np.array(record["time"]), np.array(record["impact.count"])
    twice = times[1:][(np.diff(times) == 0.0) & (np.diff(counts) > 0)]
    np.testing.assert_array_equal(twice, np.unique(impacts["onset"]))


@pytest.mark.full("takes long")
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("model", MODELS)
def test_a_program_in_c_returns_at_every_impact(all_fmus, tmp_path, expected, model, size):
    program, fmu = tmp_path / "host3", all_fmus["fmi3"][model]
    headers = [f"-I{place}" for place in INCLUDES]
    zig(tmp_path, *WARNINGS, *headers, __file__.replace("test_recovery.py", "host3.c"), "-o", program, "-ldl")
    place, root, scene = unpacked(fmu, tmp_path / "fmu"), description(fmu), load_scene(model)
    references = {node.get("name"): node.get("valueReference") for node in root.find("ModelVariables")}
    done = subprocess.run(
        [
            program,
            place / "binaries" / "x86_64-linux" / f"{scene.name}.so",
            root.get("instantiationToken"),
            f"{place}/resources/",
            *map(str, (size, scene.simulation.stop_time)),
            *(references[name] for name in ("impact.last_time", "impact.count", "point.position")),
            str(2 * (len(scene.chain.links) + 1)),
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    *events, last = ([float(word) for word in line.split()] for line in done.stdout.splitlines())
    onsets = np.unique(expected[model].impacts["onset"])
    np.testing.assert_array_equal([time for time, *_ in events], onsets)
    np.testing.assert_array_equal([impact for _, impact, _ in events], onsets)
    assert events[-1][2] == len(expected[model].impacts)
    np.testing.assert_allclose(last, expected[model].points[-1].ravel(), rtol=0, atol=1e-12)
