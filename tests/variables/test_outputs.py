"""The outputs of a scene and their descriptions, group by group."""

# Tests: variables/impact_units.py, variables/peaks.py, variables/variable.py

import numpy as np
import pytest

from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.kernel.tangent.duals import DIRECTIONS
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.simulate import simulate
from chain_impact.variables import scene_variables
from chain_impact.variables.impact_units import IMPACT_UNITS
from chain_impact.variables.peaks import PEAKS
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.scene_variables import outputs_of_scene
from chain_impact.variables.selection import differentiable_named
from chain_impact.variables.variable import Variable

BOX, ARM = load_scene("four_link_box"), load_scene("pinned_arm")
# unit → the last parts of the names of outputs of BOX with this unit
OF_UNIT = {
    "m": "x y penetration max_penetration",
    "m/s": "vx vy penetration_rate last_speed speed separation_speed",
    "m/s2": "ax ay",
    "rad": "angle",
    "rad/s": "angular_velocity",
    "rad/s2": "angular_acceleration",
    "N": "force peak_force",
    "N.s": "impulse",
    "J": "kinetic potential elastic dissipated total",
    "s": "time last_time end",
}
# key of [outputs] → a name that exists only with this key
GROUPS = {
    "points": "point[0].x",
    "links": "link[1].angle",
    "contacts": "contact[0].y_min.force",
    "energies": "energy.total",
    "solver": "solver.steps",
}


@pytest.mark.parametrize("left_out", GROUPS)
def test_a_group_that_is_not_asked_for_is_not_there(left_out):
    all_names, group_less_names = (
        {variable.name for variable in outputs_of_scene(scene).values()}
        for scene in (BOX, BOX.with_values({f"outputs.{left_out}": False}))
    )
    assert {key for key, name in GROUPS.items() if name not in group_less_names} == {left_out}
    parts = {name.split("[")[0].split(".")[0] for name in all_names - group_less_names}
    assert parts <= {left_out.removesuffix("s"), "energy", "solver"}


def test_an_output_has_the_unit_of_its_quantity():
    units_by_key = {
        (name.split(".")[-1], output.unit)
        for name, output in outputs_of_scene(BOX).items()
        if output.type == "real"
    }
    assert units_by_key == {(key, unit) for unit, keys in OF_UNIT.items() for key in keys.split()}


def test_a_joint_that_exists_has_its_angle_and_rate():
    joint_outputs = {
        name: output for name, output in outputs_of_scene(BOX).items() if name.startswith("joint[")
    }
    assert list(joint_outputs) == [
        f"joint[{i}].{key}" for i in (2, 3, 4) for key in ("angle", "angular_velocity")
    ]
    assert [output.unit for output in joint_outputs.values()] == 3 * ["rad", "rad/s"]
    assert {"joint[1].angle", "joint[1].angular_velocity"} <= set(outputs_of_scene(ARM))


@pytest.mark.parametrize("output", [(), "point[4].x", ["energy.*", "solver.steps"]])
def test_to_choose_outputs_makes_no_variables_again(monkeypatch, output):
    """Another scene that differs only in numbers has the same variables."""
    made_kinds = []

    def counted(kind, *_):
        made_kinds.append(kind.name)

    simulate(BOX, stop_time=0.01, output="energy.total")
    monkeypatch.setattr(Variable, "from_kind", counted)
    changed_scene = BOX.with_values({"contact.restitution": 0.4, "link[1].mass": 1.5})
    for scene in (BOX, changed_scene):
        simulate(scene, stop_time=0.01, output=output)
    assert made_kinds == []


SHAPES = {
    "link[2].joint_min": -3.0,
    "link[2].joint_friction": 0.1,
    "contact.friction": 0.2,
    "box.x_max": None,
}
SHAPES |= {"contact.points": [0, 4], "inputs.tip_force": True, "outputs.impacts": 2, "outputs.solver": False}


@pytest.mark.parametrize(("name", "value"), SHAPES.items())
def test_kept_parts_of_a_scene_are_not_taken_for_another_one(name, value):
    box_outputs, changed_scene = outputs_of_scene(BOX), BOX.with_values({name: value})
    changed_outputs = outputs_of_scene(changed_scene)
    scene_variables.outputs_of.cache_clear()
    assert changed_outputs == outputs_of_scene(changed_scene)
    assert changed_outputs != box_outputs


@pytest.mark.parametrize("scene", [BOX, ARM], ids=["free", "pinned"])
def test_only_the_base_of_a_pinned_chain_is_held(scene):
    names_at_rest = {variable.name for variable in outputs_of_scene(scene).values() if variable.base_at_rest}
    base_names = {f"point[0].{prefix}{axis}" for prefix in ("", "v", "a") for axis in "xy"}
    assert names_at_rest == (base_names if scene is ARM else set())


def test_an_input_says_between_which_links_its_torque_acts():
    descriptions = {variable.name: variable.description for variable in PreparedScene(ARM).inputs}
    assert descriptions["joint[1].torque"] == "torque on link 1 from the base"
    assert descriptions["joint[2].torque"] == "torque on link 2 from link 1"
    driven_box = BOX.with_values({"inputs.joint_torques": True})
    assert PreparedScene(driven_box).inputs[0].description == "torque on link 2 from link 1"


def test_behind_an_instance_are_those_that_carry_its_derivatives():
    """Each record of dual numbers has the values of the instance, and slope 1 only for its own parameters."""
    prepared_scene = PreparedScene(BOX)
    names = [f"link[{i}].mass" for i in range(1, 5)] + ["contact.stiffness", "link[2].length"]
    parameters = differentiable_named(prepared_scene, names)
    plain, memory = prepared_scene.new_instance([])[0], prepared_scene.new_instance(parameters)[0]
    count = -(-len(names) // DIRECTIONS)
    assert (plain["tangent_count"], memory["tangent_count"]) == (0, count)
    dual_records = memory[memory.dtype.names[-1]]
    assert dual_records.shape == (count,)
    for name in plain.dtype.names:
        if name != "tangent_count":
            assert memory[name].tobytes() == plain[name].tobytes()

    def check(source, duals):
        for name in set(source.dtype.names) - {"tangent_count"}:
            if source.dtype[name].base.names:
                check(source[name], duals[name])
            else:
                values = duals[name]["value"] if duals[name].dtype.names else duals[name]
                np.testing.assert_array_equal(values, source[name])

    slopes = np.zeros((count, DIRECTIONS))
    for number, variable in enumerate(parameters):
        t = number // DIRECTIONS
        check(plain, dual_records[t])
        field = dual_records[t]
        for step in variable.record_path:
            field = field[step]
        assert field["slope"].tolist() == [float(k == number % DIRECTIONS) for k in range(DIRECTIONS)]
        slopes[t, number % DIRECTIONS] = 1.0

    reals = sum(int(total_slopes(dual_records[t])) for t in range(count))
    assert reals == slopes.sum() == len(names)


def total_slopes(duals):
    names = duals.dtype.names or ()
    return (
        np.abs(duals["slope"]).sum() if "slope" in names else sum(total_slopes(duals[name]) for name in names)
    )


def test_numbers_of_points_and_walls_have_the_limits_that_their_texts_tell():
    """Point −1 and wall 0 mean none."""
    limits = {
        variable.name: (variable.minimum, variable.maximum) for variable in outputs_of_scene(BOX).values()
    }
    for prefix in ("impact.last_", "impact[1].", "impact[2]."):
        assert limits[f"{prefix}point"] == (-1, 4)
        assert limits[f"{prefix}wall"] == (0, 4)
        assert limits[f"{prefix}speed"] == (0.0, None)
    assert limits["impact.count"] == (0, None)
    assert limits["impact[1].peak_force"] == limits["impact[1].max_penetration"] == (0.0, None)
    assert limits["solver.steps"] == (0, None)
    assert limits["solver.status"] == (0, max(STATUS_TEXT))
    rubbing = outputs_of_scene(BOX.with_values({"contact.friction": 0.1}))
    assert rubbing["solver.status"].maximum == max(STATUS_TEXT)


def test_the_latest_impacts_and_the_peaks_have_the_units_of_impacts():
    quantities = {"time": "onset", "speed": "impact_speed"}
    units = {
        output.name: output.unit
        for output in PreparedScene(BOX).outputs
        if output.name.startswith("impact[1].") and output.unit
    }
    ends = {name.removeprefix("impact[1]."): unit for name, unit in units.items()}
    units_by_quantity = {quantities.get(name, name): unit for name, unit in ends.items()}
    assert units_by_quantity == {name: IMPACT_UNITS[name] for name in units_by_quantity}
    assert len(units_by_quantity) >= 7
    assert [PEAKS[name].unit for name in ("peak_force", "max_penetration")] == ["N", "m"]
    assert [PEAKS[name].fmi_unit for name in ("stop.peak_moment", "stop.max_penetration")] == ["N.m", "rad"]
