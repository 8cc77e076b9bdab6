"""What is in an FMU: valid, complete, reproducible, small, and nothing that an importer has to install."""

import zipfile
from pathlib import Path

import pytest

from chain_impact import load_scene
from chain_impact.compilation.errors import BuildError
from chain_impact.export import fmu as export
from chain_impact.export.fmu import TARGETS, build_fmu, validate_fmu
from chain_impact.instance import new_instance
from chain_impact.scene import model_names, with_values
from chain_impact.variables import fmu_variables, word_index
from tests.fmu.contents import description

every_model = pytest.mark.parametrize("model", model_names())


@every_model
def test_fmpy_finds_nothing_wrong(fmus, model):
    assert validate_fmu(fmus[model]) == []


@every_model
def test_an_fmu_is_named_after_its_model_and_small(fmus, model):
    path = Path(fmus[model])
    assert path.name == f"{load_scene(model).name}.fmu"
    assert path.stat().st_size < 2e6


def test_two_builds_have_equal_bytes(fmus, target, tmp_path):
    assert build_fmu("rod_drop", tmp_path, target=target).read_bytes() == Path(fmus["rod_drop"]).read_bytes()


def test_another_value_makes_another_guid(fmus, target, tmp_path):
    scene = with_values(load_scene("rod_drop"), {("contact", "stiffness"): 2e8})
    other = str(build_fmu(scene, tmp_path, target=target))
    assert description(other).get("guid") != description(fmus["rod_drop"]).get("guid")


def test_names_are_sorted_and_nothing_is_dated(fmus):
    with zipfile.ZipFile(fmus["rod_drop"]) as fmu:
        assert fmu.namelist() == sorted(fmu.namelist())
        assert {entry.date_time for entry in fmu.infolist()} == {(1980, 1, 1, 0, 0, 0)}


# --- the model description -------------------------------------------------------------------------------


@every_model
def test_start_values_are_those_of_the_scene_to_the_last_bit(fmus, model):
    scene = load_scene(model)
    instance = new_instance(scene)
    nodes = description(fmus[model]).iter("ScalarVariable")
    found = {node.get("name"): node[0].get("start") for node in nodes}
    for variable in fmu_variables(scene):
        start = found.pop(variable.name)
        if variable.causality == "output":
            assert start is None
        else:
            words = instance.view("f8" if variable.type == "real" else "i8")
            assert float(start) == words[word_index(instance.dtype, variable.place)]
    assert not found


@every_model
def test_units_types_and_unknowns_are_complete(fmus, model):
    root = description(fmus[model])
    assert root.get("generationDateAndTime").endswith("Z")
    assert root.get("variableNamingConvention") == "structured"
    units = {unit.get("name") for unit in root.iter("Unit")}
    types = {simple.get("name") for simple in root.iter("SimpleType")}
    outputs = set()
    for number, node in enumerate(root.iter("ScalarVariable"), 1):
        value = node[0]
        if value.tag == "Real":
            assert value.get("unit") in units
        if value.tag != "Integer":
            assert value.get("declaredType") in types
        if node.get("causality") == "output":
            outputs.add(str(number))
    for part in ("Outputs", "InitialUnknowns"):
        indices = [unknown.get("index") for unknown in root.find(f"ModelStructure/{part}")]
        assert indices == sorted(outputs, key=int)


def test_inputs_act_at_once_on_accelerations_and_forces_only(fmus):
    """On forces, as rigid walls hold against a torque, and the law can be changed."""
    root = description(fmus["pinned_arm"])
    names = [node.get("name") for node in root.iter("ScalarVariable")]
    for unknown in root.find("ModelStructure/Outputs"):
        name = names[int(unknown.get("index")) - 1]
        on = [names[int(number) - 1] for number in unknown.get("dependencies").split()]
        at_once = name.endswith((".ax", ".ay", "angular_acceleration", ".force"))
        assert on == (["joint[1].torque", "joint[2].torque"] if at_once else [])


def test_capabilities(fmus, target):
    cosimulation = description(fmus["rod_drop"]).find("CoSimulation")
    assert cosimulation.attrib == {
        "modelIdentifier": "RodDrop",
        "needsExecutionTool": "false",
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true" if target == "pythonfmu" else "false",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }


@every_model
def test_both_targets_have_the_same_description(all_fmus, model):
    both = [description(all_fmus[target][model]) for target in TARGETS]
    for root in both:
        del root.attrib["guid"], root.attrib["generationTool"]
        del root.find("CoSimulation").attrib["canNotUseMemoryManagementFunctions"]
    first, second = ([(n.tag, n.attrib, (n.text or "").strip()) for n in root.iter()] for root in both)
    assert first == second


# --- what can go wrong -----------------------------------------------------------------------------------


@pytest.mark.parametrize("platforms", [(), ("linux64", "amiga")])
def test_an_unknown_platform_is_refused(tmp_path, target, platforms):
    with pytest.raises(BuildError, match=r"platforms = .* must be some of linux64, win64"):
        build_fmu("rod_drop", tmp_path, target=target, platforms=platforms)


def test_an_unknown_target_is_refused(tmp_path):
    with pytest.raises(BuildError, match=r"target = 'fortran' must be one of pythonfmu, native"):
        build_fmu("rod_drop", tmp_path, target="fortran")


def test_an_invalid_fmu_does_not_appear(tmp_path, monkeypatch, fmus):
    monkeypatch.setattr(export, "validate_fmu", lambda _path: ["no good", "at all"])
    with pytest.raises(BuildError, match=r"RodDrop\.fmu is not valid: no good; at all"):
        build_fmu("rod_drop", tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_folder_is_made(tmp_path, fmus):
    assert build_fmu("rod_drop", tmp_path / "a" / "b") == tmp_path / "a" / "b" / "RodDrop.fmu"
    assert [path.name for path in (tmp_path / "a" / "b").iterdir()] == ["RodDrop.fmu"]
