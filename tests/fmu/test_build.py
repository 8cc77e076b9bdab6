"""What is in an FMU: valid, complete, reproducible, small, and nothing that an importer has to install."""

import ast
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

from chain_impact import load_scene
from chain_impact.compilation.errors import BuildError
from chain_impact.export import fmu as export
from chain_impact.export.fmu import build_fmu, slave_source, validate_fmu
from chain_impact.instance import new_instance
from chain_impact.scene import model_names, with_values
from chain_impact.variables import fmu_variables, word_index

every_model = pytest.mark.parametrize("model", model_names())


def description(path: str) -> ElementTree.Element:
    with zipfile.ZipFile(path) as fmu:
        return ElementTree.fromstring(fmu.read("modelDescription.xml"))


@every_model
def test_fmpy_finds_nothing_wrong(fmus, model):
    assert validate_fmu(fmus[model]) == []


@every_model
def test_an_fmu_is_named_after_its_model_and_small(fmus, model):
    path = Path(fmus[model])
    assert path.name == f"{load_scene(model).name}.fmu"
    assert path.stat().st_size < 2e6


def test_two_builds_have_equal_bytes(fmus, tmp_path):
    assert build_fmu("rod_drop", tmp_path).read_bytes() == Path(fmus["rod_drop"]).read_bytes()


def test_another_value_makes_another_guid_and_script(fmus, tmp_path):
    scene = with_values(load_scene("rod_drop"), {("contact", "stiffness"): 2e8})
    other = str(build_fmu(scene, tmp_path))
    assert description(other).get("guid") != description(fmus["rod_drop"]).get("guid")
    scripts = [set(zipfile.ZipFile(path).namelist()) for path in (other, fmus["rod_drop"])]
    assert not {name for name in scripts[0] & scripts[1] if name.startswith("resources/chain_impact")}


def test_only_the_files_that_are_needed(fmus):
    names = zipfile.ZipFile(fmus["rod_drop"]).namelist()
    assert names == sorted(names)
    rest = [name for name in names if not name.startswith("resources/pythonfmu/")]
    (script,) = [name for name in rest if name.endswith(".py")]
    resources = ("instance.bin", "kernel-linux64.so", "model.json", "slavemodule.txt")
    expected = {f"resources/{name}" for name in resources}
    assert set(rest) == expected | {"modelDescription.xml", "binaries/linux64/RodDrop.so", script}


def test_the_slave_imports_the_standard_library_and_pythonfmu_only():
    imported = set()
    # the oldest Python for which pythonfmu's wrapper works
    for node in ast.walk(ast.parse(slave_source(), feature_version=(3, 8))):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            imported.add(node.module)
    assert {name.partition(".")[0] for name in imported} <= sys.stdlib_module_names | {"pythonfmu"}


# --- the model description -------------------------------------------------------------------------------


def test_capabilities(fmus):
    cosimulation = description(fmus["rod_drop"]).find("CoSimulation")
    assert cosimulation.attrib == {
        "modelIdentifier": "RodDrop",
        "needsExecutionTool": "false",
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }


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


# --- what can go wrong -----------------------------------------------------------------------------------


@pytest.mark.parametrize("platforms", [(), ("linux64", "darwin64")])
def test_an_unknown_platform_is_refused(tmp_path, platforms):
    with pytest.raises(BuildError, match=r"platforms = .* must be some of linux64, win64"):
        build_fmu("rod_drop", tmp_path, platforms=platforms)


def test_an_invalid_fmu_does_not_appear(tmp_path, monkeypatch, fmus):
    monkeypatch.setattr(export, "validate_fmu", lambda _path: ["no good", "at all"])
    with pytest.raises(BuildError, match=r"RodDrop\.fmu is not valid: no good; at all"):
        build_fmu("rod_drop", tmp_path)
    assert not list(tmp_path.iterdir())


def test_what_the_builder_says_is_passed_on(tmp_path, monkeypatch, fmus):
    monkeypatch.setattr(export, "slave_source", lambda: b"raise RuntimeError('broken')\n")
    with pytest.raises(BuildError, match="RuntimeError: broken"):
        build_fmu("rod_drop", tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_folder_is_made(tmp_path, fmus):
    assert build_fmu("rod_drop", tmp_path / "a" / "b") == tmp_path / "a" / "b" / "RodDrop.fmu"
    assert [path.name for path in (tmp_path / "a" / "b").iterdir()] == ["RodDrop.fmu"]


@pytest.mark.slow
def test_an_fmu_for_both_platforms(tmp_path):
    fmu = build_fmu("rod_drop", tmp_path, platforms=("linux64", "win64"))
    names = zipfile.ZipFile(fmu).namelist()
    binaries = [name for name in names if name.startswith("binaries")]
    assert binaries == ["binaries/linux64/RodDrop.so", "binaries/win64/RodDrop.dll"]
    with zipfile.ZipFile(fmu) as archive:
        assert archive.read("resources/kernel-linux64.so").startswith(b"\x7fELF")
        assert archive.read("resources/kernel-win64.dll").startswith(b"MZ")
    assert fmu.stat().st_size < 2e6
