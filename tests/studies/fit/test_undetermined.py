"""Notes on parameters that the data do not determine, alone or together with others."""

import math

from chain_impact import fit, load_scene, simulate
from tests.helpers.tools.measurements import FREE, NOISE, TIP, impacts, motion, scene

SIGMA = dict.fromkeys(TIP, NOISE)


def test_six_impacts_determine_all_parameters():
    assert fit(scene(), motion(1.2)[0], FREE, sigma=SIGMA).unknown == ()


def test_stiffness_is_unknown_after_one_impact_and_a_peak_force_tells_it():
    columns, result = motion(0.51)
    assert len(result.impacts) == 1
    fit_result = fit(scene(), columns, FREE, sigma=SIGMA)
    (note,) = fit_result.unknown
    error = fit_result.standard_errors[FREE[0]] / fit_result.values[FREE[0]]
    assert note == (
        f"contact.stiffness is not determined by these data: its standard error is {100 * error:.2g} %."
    )
    table = impacts(result, ["peak_force"])
    fit_with_force = fit(scene(), [[columns, table]], FREE, sigma=SIGMA | {"peak_force": "2%"})
    assert fit_with_force.unknown == ()


def test_a_parameter_without_effect_is_told():
    notes = fit(scene(), motion(0.4)[0], FREE, sigma=SIGMA).unknown
    assert notes == tuple(f"{name} has no effect on the measured values." for name in FREE[:2])


def test_masses_are_known_up_to_a_factor():
    """A motion without external forces determines masses and inertias up to a common factor only."""
    arm = load_scene("pinned_arm").with_values({"box.x_max": 5.0})
    result = simulate(arm, stop_time=1.0, output_step=0.02)
    names = ["link[1].mass", "link[1].inertia", "link[2].mass", "link[2].inertia"]
    names += ["link[1].joint_damping", "link[2].joint_damping"]
    columns = {"time": result.time, **{f"link[{i}].angle": result[f"link[{i}].angle"] for i in (1, 2)}}
    sigma = {f"link[{i}].angle": 1e-5 for i in (1, 2)}
    fit_result = fit(arm, columns, names, sigma=sigma)
    assert len(fit_result.unknown) == len(names)
    assert (
        "link[1].mass is not determined by these data: its standard error is infinite."
        in fit_result.unknown[0]
    )
    assert "It acts together with link[" in fit_result.unknown[0]
    assert fit_result.intervals["link[1].mass"] == (0.0, math.inf)
    line = next(line for line in repr(fit_result).splitlines() if line.startswith("link[1].mass"))
    assert line.endswith("not determined")
    fit_with_known_mass = fit(arm, columns, names[1:], sigma=sigma)
    assert fit_with_known_mass.unknown == ()
