"""FMUs of scenes with signals: they drive themselves, and carry their tables."""

import zipfile

import fmpy
import numpy as np
import pytest

from chain_impact import build_fmu, simulate
from tests.simulation.test_signals import TIMES, TORQUE, with_table
from tests.tiers import needs_compilers

pytestmark = needs_compilers
KINDS = [{"target": "pythonfmu"}, {"target": "native"}, {"target": "native", "fmi": 3}]


@pytest.mark.parametrize("kind", KINDS, ids=["pythonfmu", "FMI 2", "FMI 3"])
def test_an_fmu_drives_itself_to_the_bit_whatever_the_communication_step(tmp_path, kind):
    values = {TORQUE: np.sin(20.0 * TIMES)}
    extra = '[signals.shake]\ninput = "base.y"\nform = "sine"\namplitude = 0.01\nfrequency = 8.0'
    scene = with_table(tmp_path, values, {"time": TIMES, **values}, extra)
    fmu = build_fmu(scene, tmp_path / "fmu", **kind)
    run, names = simulate(scene), ["link[2].angle", "base.vy", TORQUE]
    for step in (0.01, 0.003):
        found = fmpy.simulate_fmu(str(fmu), stop_time=0.6, step_size=step, output_interval=step, output=names)
        assert [found[name][-1] for name in names] == [run[name][-1] for name in names]
    changed = {"signal.shake.amplitude": 0.02}
    found = fmpy.simulate_fmu(
        str(fmu), stop_time=0.6, output_interval=0.01, output=names, start_values=changed
    )
    assert found[names[0]][-1] == simulate(scene.with_values(changed))[names[0]][-1]
    with zipfile.ZipFile(fmu) as files:
        assert not [name for name in files.namelist() if str(tmp_path).encode() in files.read(name)]
