"""Every value has a name in the FMU and a key in the scene file: both are accepted everywhere."""

# Tests: scene/texts/names.py, studies/fit/parameters.py

import pytest

from chain_impact import SceneError, load_scene, simulate, sweep
from chain_impact.scene.scene import parse_scene
from chain_impact.scene.texts.names import fmu_name
from chain_impact.studies.fit.parameters import fitted_parameters
from tests.helpers.scenes.stops import knee_scene

FMU_NAMES = {
    "contact.wall.x_max.restitution": "wall.x_max.restitution",
    "stops.stiffness": "stop.stiffness",
    "chain.links[2].mass": "link[2].mass",
    "initial.angles[1]": "initial.angle[1]",
    "initial.position[2]": "initial.y",
    "gravity[2]": "gravity.y",
}


def walled():
    """Return a scene with stops, and a wall of a material of its own."""
    return knee_scene().with_values({"wall.x_max.restitution": 0.4})


@pytest.mark.parametrize("key", FMU_NAMES)
def test_a_key_of_the_file_is_the_name_of_the_fmu(key):
    assert fmu_name(key) == fmu_name(FMU_NAMES[key]) == FMU_NAMES[key]


@pytest.mark.parametrize(
    "name", ["", ".", "walls[1].point[1]", "initial.position[9]", "a" * 99, "x[" + "9" * 5000]
)
def test_names_that_are_no_keys_do_not_change(name):
    assert fmu_name(name) == name


@pytest.mark.parametrize("key", FMU_NAMES)
def test_values_sweeps_fits_and_derivatives_take_the_key(key):
    scene, value = walled(), 0.37
    changed_scene = scene.with_values({key: value})
    assert changed_scene == scene.with_values({FMU_NAMES[key]: value}) != scene
    rows = sweep(scene.with_values({"simulation.stop_time": 0.01}), {key: [value]})
    assert rows[FMU_NAMES[key]].tolist() == [value]
    (parameter,) = fitted_parameters([changed_scene], [key], [], {key: (0.1, 0.9)})
    assert (parameter.name, parameter.start, parameter.low, parameter.high) == (
        FMU_NAMES[key],
        value,
        0.1,
        0.9,
    )
    if key.startswith("stops"):
        result = simulate(scene, 0.01, sensitivities=[key])
        assert list(result.sensitivities.parameters) == [FMU_NAMES[key]]


@pytest.mark.parametrize(
    "name",
    ["contact.wall.x_max.restitution", "wall.x_max.restitution", "stops.restitution", "stop.restitution"],
)
def test_an_error_uses_the_name_that_was_typed(name):
    scene = walled()
    with pytest.raises(SceneError) as caught:
        scene.with_values({name: -1.0})
    assert str(caught.value).startswith(f"{scene.name}: {name} = -1.0 must be ")
    with pytest.raises(SceneError) as caught:
        sweep(scene, {name: "-1,0.5"})
    assert str(caught.value).startswith(f"{scene.name}: {name} = -1 must be ")
    if name.startswith("stop"):
        with pytest.raises(SceneError) as caught:
            load_scene("rod_drop").with_values({name: 0.5})
        assert str(caught.value).startswith(f"RodDrop: {name} = 0.5 must be left out")


def test_an_error_has_the_parts_of_its_message():
    with pytest.raises(SceneError) as caught:
        load_scene("rod_drop").with_values({"contact.restitution": -1.0})
    error = caught.value
    assert (error.path, error.name, error.line) == (("contact", "restitution"), "contact.restitution", None)
    assert str(error) == f"RodDrop: {error.name} {error.fault}"
    assert repr(error) == f"SceneError({str(error)!r})"
    assert error.fault.startswith("= -1.0 must be ")
    with pytest.raises(SceneError) as caught:
        parse_scene("name = 1\n[chain]\nlinks = []", "one.toml")
    error = caught.value
    assert (error.source, error.name, error.line) == ("one.toml", "name", 1)
    (second_error,) = error.others
    assert (second_error.source, second_error.name, second_error.line) == ("", "chain.links", 3)
    assert (
        str(error)
        == f"one.toml: name {error.fault} (at line 1); 1 more: chain.links {second_error.fault} (at line 3)"
    )
