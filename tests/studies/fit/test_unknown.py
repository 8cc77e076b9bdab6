"""Parameters that the data cannot determine, and their companions; tests confirm each statement by runs."""

import math

from chain_impact import fit, load_scene, simulate
from tests.helpers.tools.measurements import FREE, NOISE, TIP, impacts, motion, scene

SIGMA = dict.fromkeys(TIP, NOISE)


def test_six_impacts_determine_all_parameters():
    assert fit(scene(), motion(1.2)[0], FREE, sigma=SIGMA).unknown == ()


def test_stiffness_is_unknown_after_one_impact_and_a_peak_force_tells_it():
    columns, result = motion(0.51)
    assert len(result.impacts) == 1
    found = fit(scene(), columns, FREE, sigma=SIGMA)
    (said,) = found.unknown
    error = found.standard_errors[FREE[0]] / found.values[FREE[0]]
    assert said == (
        f"contact.stiffness is not determined by these data: its standard error is {100 * error:.2g} %."
    )
    table = impacts(result, ["peak_force"])
    told = fit(scene(), [[columns, table]], FREE, sigma=SIGMA | {"peak_force": "2%"})
    assert told.unknown == ()


def test_a_parameter_without_effect_is_told():
    said = fit(scene(), motion(0.4)[0], FREE, sigma=SIGMA).unknown
    assert said == tuple(f"{name} has no effect on the measured values." for name in FREE[:2])


def test_masses_are_known_up_to_a_factor():
    """A motion without external forces determines masses and inertias up to a common factor only."""
    arm = load_scene("pinned_arm").with_values({"box.x_max": 5.0})
    result = simulate(arm, stop_time=1.0, output_step=0.02)
    names = ["link[1].mass", "link[1].inertia", "link[2].mass", "link[2].inertia"]
    names += ["link[1].joint_damping", "link[2].joint_damping"]
    columns = {"time": result.time, **{f"link[{i}].angle": result[f"link[{i}].angle"] for i in (1, 2)}}
    sigma = {f"link[{i}].angle": 1e-5 for i in (1, 2)}
    found = fit(arm, columns, names, sigma=sigma)
    assert len(found.unknown) == len(names)
    assert "link[1].mass is not determined by these data: its standard error is infinite." in found.unknown[0]
    assert "It acts together with link[" in found.unknown[0]
    assert found.intervals["link[1].mass"] == (0.0, math.inf)
    line = next(line for line in repr(found).splitlines() if line.startswith("link[1].mass"))
    assert line.endswith("not determined")
    held = fit(arm, columns, names[1:], sigma=sigma)
    assert held.unknown == ()
