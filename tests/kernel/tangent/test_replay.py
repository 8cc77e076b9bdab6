"""Each step once more in dual numbers: the values are those of the run, whatever happens in it."""

import numpy as np
import pytest

from chain_impact import simulate
from tests.derivative_scenes import AT_STOPS, pinned_chain, pressed_tip, sprung_chain, struck_twice
from tests.kernel.tangent.dual import followed, started

CASES = {
    "explicit": sprung_chain(),
    "implicit": sprung_chain(method="implicit"),
    "rigid": pinned_chain("newton_impact"),
    "pressed": pressed_tip(),
    "with a jump": struck_twice("kelvin_voigt"),
    "other root": struck_twice("kuwabara_kono"),
    "stop": AT_STOPS["stop, rigid wall"],
}
# what the last step is, and what is told: the same bits
SAME = {
    "step": ("start", "end", "size", "state", "state_end", "dense", "kept", "regularized"),
    "touch": ("active", "onset", "onset_speed", "impact_speed", "effective_mass", "damping", "peak_force"),
    "finished": ("onset", "end", "impact_speed", "separation_speed", "peak_force", "max_penetration"),
    "output": (
        "point_position",
        "point_velocity",
        "point_acceleration",
        "angle",
        "force",
        "total",
        "dissipated",
    ),
}


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("name", CASES)
def test_values_are_those_of_the_run(name):
    case = CASES[name]
    instance = started(case)
    d, t = instance.record, instance._tangents
    for time in np.linspace(0.0, case.scene.simulation.stop_time, 24):
        followed(instance, [time])
        for record, fields in SAME.items():
            for field in fields:
                right, found = d[record][field], t[record][field]
                found = found["value"] if found.dtype.names else found
                for block in found:
                    np.testing.assert_array_equal(block, right, err_msg=f"{record}.{field} at {time} s")
    assert d["impact"]["count"] >= 1
    np.testing.assert_allclose(
        t["output"]["impulse"]["value"][0],
        d["output"]["impulse"],
        atol=1e-9 * np.abs(d["output"]["impulse"]).max(),
    )


@pytest.mark.parametrize("name", CASES)
def test_the_run_is_the_same_with_derivatives_and_without(name):
    case = CASES[name]
    values, _ = followed(started(case), [*case.times])
    plain = simulate(case.scene, inputs=case.inputs, output_step=case.scene.simulation.stop_time)
    np.testing.assert_array_equal(values[-1], [column[-1] for column in plain.motion.values()])
