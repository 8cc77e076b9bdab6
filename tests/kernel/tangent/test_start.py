"""How an instance of dual numbers begins."""

import math

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from tests.complex_laws import FAMILY, WITH_MASS
from tests.complex_step import TINY
from tests.derivative_scenes import Case, pinned_chain, sprung_chain, struck_twice
from tests.kernel.tangent.dual import followed, started
from tests.problems import ball, of_law

FACTORS = FAMILY | {name: factor for name, (factor, *_) in WITH_MASS.items()}


def damping_factor(law, e):
    """What an instance of dual numbers makes of a restitution: value and slope."""
    scene = ball(1e-3, 1.0, restitution=e, **of_law(law))
    contact = started(Case(scene, ("contact.restitution",), ()))._tangents["law"]["damping_factor"][0, 0]
    return contact["value"], contact["slope"][0]


@pytest.mark.parametrize("e", [0.1, 0.3, 0.5, 0.7, 0.95])
@pytest.mark.parametrize("law", FACTORS)
def test_the_factor_of_a_law_varies_with_the_restitution(law, e):
    found = complex(FACTORS[law](complex(e, TINY)))
    value, slope = damping_factor(law, e)
    # the kernel's own f(e) of Kuwabara and Kono has 10 digits
    bound = 1e-7 if law == "kuwabara_kono" else 1e-11
    assert value == pytest.approx(found.real, rel=bound, abs=1e-14)
    assert slope == pytest.approx(found.imag / TINY, rel=bound, abs=1e-14)


def test_every_law_with_a_force_has_a_factor():
    assert {*CONTACT_LAWS} - {*FACTORS} == {"newton_impact"}


def values_of(record):
    return record["value"] if record.dtype.names == ("value", "slope") else record


def assert_same_values(tangents, own, path):
    """That the values of each instance of dual numbers are those of the instance, field by field."""
    for name in own.dtype.names or ():
        assert_same_values(tangents[name], own[name], f"{path}.{name}")
    if not own.dtype.names:
        for block in values_of(tangents):
            np.testing.assert_array_equal(block, own, err_msg=path)


PARTS = ("model", "contact", "stops", "initial", "solver", "walls", "given", "candidate", "law")


def forget_values(record):
    """Put numbers that are wrong in place of all values; derivatives stay."""
    for name in record.dtype.names:
        if record.dtype[name].base.names == ("value", "slope"):
            record[name]["value"] = -7.5
        elif record.dtype[name].names:
            forget_values(record[name])


@pytest.mark.parametrize(
    "case",
    [
        *(sprung_chain(), pinned_chain(), struck_twice("tsuji")),
        Case(load_scene("ramp"), ("contact.stiffness",), ()),
    ],
    ids=["sprung", "pinned", "tsuji", "walls at angles"],
)
def test_a_start_takes_all_values_of_the_instance(case):
    """So that a second run with other parameters differentiates at these."""
    instance = started(case)
    d, t = instance.record, instance._tangents
    for part in PARTS:
        forget_values(t[part])
    t["model"]["pinned"] = 1 - d["model"]["pinned"]
    t["law"]["number"] = 0
    instance.initialize()
    for part in PARTS:
        for name in d[part].dtype.names:
            assert_same_values(t[part][name], d[part][name], f"{part}.{name}")
    for name in ("state_end", "end", "time", "size", "method"):
        assert_same_values(t["step"][name], d["step"][name], name)
    assert (t["trust"]["reason"] == 0).all()


def test_what_follows_from_the_parameters_varies_with_them():
    """The start of two links: the angles and rates themselves, energies and the points by hand."""
    case = struck_twice("hunt_crossley")
    names = (
        "initial.angle[1]",
        "initial.angular_velocity[2]",
        "link[1].mass",
        "initial.vy",
        "link[1].length",
    )
    case = Case(case.scene, names, case.times)
    instance = started(case)
    followed(instance, [0.0])
    output = instance._tangents["output"]
    slopes = {
        name: output[name]["slope"] for name in ("angle", "angular_velocity", "point_position", "kinetic")
    }

    def of(field, parameter, *index):
        block, direction = divmod(names.index(parameter), 4)
        return slopes[field][(block, *index, direction)]

    assert of("angle", "initial.angle[1]", 0) == 1.0
    assert of("angle", "initial.angle[1]", 1) == 0.0
    assert of("angular_velocity", "initial.angular_velocity[2]", 1) == 1.0
    # l e(φ), of which both points move
    angle = case.scene.initial.angles[0]
    for k in (1, 2):
        assert of("point_position", "initial.angle[1]", k, 0) == pytest.approx(
            -0.5 * math.sin(angle), rel=1e-15
        )
        assert of("point_position", "initial.angle[1]", k, 1) == pytest.approx(
            0.5 * math.cos(angle), rel=1e-15
        )
        assert of("point_position", "link[1].length", k, 0) == pytest.approx(math.cos(angle), rel=1e-15)
    # ½ v_C² for the mass, the inertia held
    vx, vy = case.scene.initial.velocity
    omega, arm = case.scene.initial.angular_velocities[0], case.scene.chain.links[0].center_of_mass
    speed = (vx - omega * arm * math.sin(angle), vy + omega * arm * math.cos(angle))
    assert of("kinetic", "link[1].mass") == pytest.approx(0.5 * math.hypot(*speed) ** 2, rel=1e-14)
    # the momentum
    result = instance.record["output"]
    momentum = sum(
        link.mass
        * ((1.0 - part) * result["point_velocity"][i, 1] + part * result["point_velocity"][i + 1, 1])
        for i, link in enumerate(case.scene.chain.links)
        for part in [link.center_of_mass / link.length]
    )
    assert of("kinetic", "initial.vy") == pytest.approx(momentum, rel=1e-14)
