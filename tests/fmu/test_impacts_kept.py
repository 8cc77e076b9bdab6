"""No importer loses an impact: the table of impacts from fmpy's record at large communication steps."""

import fmpy
import numpy as np
import pytest

from chain_impact import impacts_of, load_scene, simulate
from chain_impact.fmu.build import build_fmu
from tests.fmu.conftest import KINDS
from tests.random_scenes import scene as random_scene

EXACT = {"onset": 1e-9, "impact_speed": 1e-9, "end": 1e-9}  # s, m/s
SHARES = ("peak_force", "max_penetration", "impulse")


def recorded(fmu, step, stop=None):
    """What fmpy records of the impacts."""
    variables = fmpy.read_model_description(str(fmu)).modelVariables
    names = [variable.name for variable in variables if variable.name.startswith(("impact", "solver"))]
    return fmpy.simulate_fmu(str(fmu), output=names, output_interval=step, stop_time=stop)


def same(found, expected):
    assert found[["point", "wall"]].tolist() == expected[["point", "wall"]].tolist()
    for name, error in EXACT.items():
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=error, err_msg=name)
    for name in SHARES:
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-6, err_msg=name)


@pytest.mark.parametrize("step", [1e-2, 1e-1])
def test_the_default_scene_is_complete(fmus, step):
    expected = simulate(load_scene("four_link_box")).impacts
    assert len(expected) > 10
    same(impacts_of(recorded(fmus["four_link_box"], step)), expected)


@pytest.mark.full("more cases", but=2)
def test_the_dropped_rod_is_complete_if_enough_are_shown(fmus, target, tmp_path):
    """It comes to rest by ever more impacts: in a step of 100 ms there are more than 8."""
    scene = load_scene("rod_drop").with_values({"outputs.impacts": 16})
    expected = simulate(scene).impacts
    same(impacts_of(recorded(build_fmu(scene, tmp_path, **KINDS[target]), 0.1)), expected)

    record = recorded(fmus["rod_drop"], 0.1)
    some = impacts_of(record)
    assert record["impact.count"][-1] == len(expected) > len(some)  # it shows that some are missing
    same(some, expected[np.isin(expected["onset"], some["onset"])])


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize(("seed", "stop"), [(9000193, 0.25), (8000264, 0.0625), (9000359, 0.125)])
def test_impacts_do_not_depend_on_the_communication_step(target, tmp_path, seed, stop):
    """Dry friction, stops and rigid walls; the times are binary fractions, which no step rounds."""
    scene = random_scene(seed).with_values({"outputs.impacts": 16})
    fmu = build_fmu(scene, tmp_path, **KINDS[target])
    first, *others = (recorded(fmu, stop / steps, stop)[-1].tobytes() for steps in (1, 64, 1024))
    assert others == [first, first]
