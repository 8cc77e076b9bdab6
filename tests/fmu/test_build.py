"""What is in an FMU: valid, complete, reproducible, small, and nothing that an importer has to install."""

import functools
import io
import re
import zipfile
from html import escape
from pathlib import Path

import numpy as np
import pytest
from fmpy import validation
from lark import Lark
from matplotlib import pyplot

from chain_impact import load_scene
from chain_impact.compilation.errors import BuildError
from chain_impact.fmu import build
from chain_impact.fmu.build import build_fmu, validate_fmu
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.scene import model_names, with_values
from chain_impact.variables.model import Model
from chain_impact.variables.table import word_index
from tests.fmu.conftest import KINDS
from tests.fmu.contents import description
from tests.fmu.importer import Instance

every_model = pytest.mark.parametrize("model", model_names())


PARSE = Lark.parse


@functools.cache
def parsed(_rule, name):
    """What fmpy's parser of names says, which it takes 10 ms for."""
    return PARSE(Lark(_rule, start="name"), name)


@pytest.mark.full("more cases", but=1)
@every_model
def test_fmpy_finds_nothing_wrong(fmus, model, monkeypatch):
    """Its grammar makes no difference between names that differ in their numbers only."""
    monkeypatch.setattr(
        Lark, "parse", lambda rule, name: parsed(rule.source_grammar, re.sub(r"\d+", "1", name))
    )
    assert validation.validate_fmu(fmus[model]) == []
    assert validate_fmu(fmus[model]) == []


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(
    ("name", "sentences"),
    [
        ("9x", 1),
        ("a b", 1),
        ("link[1.mass", 1),
        ("link[].mass", 1),
        ("a..b", 1),
        ("mäss", 1),
        ("der(x)", 0),
        ("'a b'", 0),
        ("a_1[1,2].b", 0),
    ],
)
def test_a_name_is_judged_as_fmpy_does(native, tmp_path, name, sentences):
    with zipfile.ZipFile(native["rod_drop"]) as old, zipfile.ZipFile(tmp_path / "x.fmu", "w") as new:
        for entry in old.namelist():
            content = old.read(entry)
            if entry == "modelDescription.xml":
                content = content.replace(b'"initial.x"', f'"{name}"'.encode())
            new.writestr(entry, content)
    found = validate_fmu(tmp_path / "x.fmu")
    assert len(found) == sentences
    assert all(f'"{name}"' in text and "is not a legal variable name" in text for text in found)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("wrong", ["unit", "backslash"])
def test_what_is_wrong_besides_names_is_said(native, tmp_path, wrong):
    with zipfile.ZipFile(native["rod_drop"]) as old, zipfile.ZipFile(tmp_path / "x.fmu", "w") as new:
        for entry in old.namelist():
            content = old.read(entry)
            if entry == "modelDescription.xml" and wrong == "unit":
                content = content.replace(b'unit="kg"', b'unit="stone"')
            name = entry.replace("resources/", "resources\\") if wrong == "backslash" else entry
            new.writestr(name, content)
    assert any(wrong in text for text in validate_fmu(tmp_path / "x.fmu"))


@pytest.mark.full("more cases", but=4)
@every_model
def test_an_fmu_is_named_after_its_model_and_small(fmus, model):
    path = Path(fmus[model])
    assert path.name == f"{load_scene(model).name}.fmu"
    assert path.stat().st_size < 2e6


@pytest.mark.full("more cases", but=2)
def test_two_builds_have_equal_bytes(fmus, target, tmp_path):
    again = build_fmu("rod_drop", tmp_path, **KINDS[target])
    assert again.read_bytes() == Path(fmus["rod_drop"]).read_bytes()


@pytest.mark.full("more cases", but=2)
def test_another_value_makes_another_guid(fmus, target, tmp_path):
    scene = with_values(load_scene("rod_drop"), {("contact", "stiffness"): 2e8})
    other = str(build_fmu(scene, tmp_path, **KINDS[target]))
    name = "instantiationToken" if target == "fmi3" else "guid"
    found = [description(path).get(name) for path in (other, fmus["rod_drop"])]
    assert None not in found
    assert found[0] != found[1]


def test_names_are_sorted_and_nothing_is_dated(fmus):
    with zipfile.ZipFile(fmus["rod_drop"]) as fmu:
        assert fmu.namelist() == sorted(fmu.namelist())
        assert {entry.date_time for entry in fmu.infolist()} == {(1980, 1, 1, 0, 0, 0)}


# --- the model description -------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=16)
@every_model
def test_start_values_are_those_of_the_scene_to_the_last_bit(fmi2, model):
    scene = load_scene(model)
    instance = Model(scene).new_instance()
    nodes = description(fmi2[model]).iter("ScalarVariable")
    found = {node.get("name"): node[0].get("start") for node in nodes}
    for variable in Model(scene).variables:
        start = found.pop(variable.name)
        if variable.causality == "output":
            assert start is None
        else:
            words = instance.view("f8" if variable.type == "real" else "i8")
            assert float(start) == words[word_index(instance.dtype, variable.place)]
    assert not found


@pytest.mark.full("more cases", but=16)
@every_model
def test_units_types_and_unknowns_are_complete(fmi2, model):
    root = description(fmi2[model])
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


def test_inputs_act_at_once_on_accelerations_and_forces_only(fmi2):
    """On forces, as rigid walls hold against a torque, and the law can be changed."""
    root = description(fmi2["pinned_arm"])
    names = [node.get("name") for node in root.iter("ScalarVariable")]
    for unknown in root.find("ModelStructure/Outputs"):
        name = names[int(unknown.get("index")) - 1]
        on = [names[int(number) - 1] for number in unknown.get("dependencies").split()]
        at_once = name.endswith((".ax", ".ay", "angular_acceleration", "force"))
        at_once &= not name.startswith("point[0]")  # the base is pinned
        assert on == (["joint[1].torque", "joint[2].torque"] if at_once else [])


def test_capabilities(all_fmus):
    for target in ("pythonfmu", "native"):
        assert description(all_fmus[target]["rod_drop"]).find("CoSimulation").attrib == {
            "modelIdentifier": "RodDrop",
            "needsExecutionTool": "false",
            "canHandleVariableCommunicationStepSize": "true",
            "canInterpolateInputs": "false",
            "canBeInstantiatedOnlyOncePerProcess": "false",
            "canNotUseMemoryManagementFunctions": "true" if target == "pythonfmu" else "false",
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
        }


@pytest.mark.full("more cases", but=16)
@every_model
def test_derivatives_nominal_values_and_ranges(fmi2, model):
    """Of outputs: rates name what they are the rate of; what cannot be negative says so."""
    nodes = list(description(fmi2[model]).iter("ScalarVariable"))
    rates = {
        node.get("name"): nodes[int(node[0].get("derivative")) - 1].get("name")
        for node in nodes
        if node[0].get("derivative")
    }
    assert rates["point[1].ay"] == "point[1].vy"
    assert rates["point[0].vx"] == "point[0].x"
    assert rates["link[1].angular_acceleration"] == "link[1].angular_velocity"
    assert rates["link[1].angular_velocity"] == "link[1].angle"
    ends = (".vx", ".vy", ".ax", ".ay", ".angular_velocity", ".angular_acceleration")
    outputs = [node.get("name") for node in nodes if node.get("causality") == "output"]
    assert list(rates) == [name for name in outputs if name.endswith(ends)]
    values = {node.get("name"): node[0].attrib for node in nodes}
    assert all(float(value.get("nominal", 1)) > 0 for value in values.values())
    assert values["energy.kinetic"]["min"] == "0.0"
    assert values["impact.last_point"]["min"] == "-1"
    assert values["solver.status"]["max"] == str(max(STATUS_TEXT))
    texts = {node.get("name"): node.get("description") for node in nodes}
    assert texts["link[1].mass"].endswith("; must be > 0")


def ranges(fmu):
    """The smallest and the largest value of each output in a run, and the limits that it has."""
    instance = Instance(fmu).start()
    rows = instance.run([0.002 * (i + 1) for i in range(1000)])
    limits = {name: instance.variables[name] for name in instance.outputs}
    return [
        [name, min(column), max(column), limits[name].min, limits[name].max]
        for name, column in zip(instance.outputs, zip(*rows, strict=True), strict=True)
    ]


def test_outputs_keep_their_ranges(fmus, clean):
    found = clean(ranges, fmus["four_link_box"])
    for name, low, high, least, most in found:
        assert least is None or low >= float(least), name
        assert most is None or high <= float(most), name
    assert len([least for *_, least, _ in found if least is not None]) > 5


def responses(fmu, laws):
    """Under each law, which outputs an input changes at once: in flight, in contact, at rest at a wall.

    By more than the solver's tolerance: points at rest are put back onto a rigid wall when it starts anew.
    """
    changed, settings = {}, {"gravity.x": 9.81, "gravity.y": 0.0}
    settings |= {"link[1].joint_damping": 2.0, "link[2].joint_damping": 2.0}
    for law in range(1, laws + 1):
        instance = Instance(fmu)
        try:
            instance.start(**settings, **{"contact.model": law})
        except Exception:  # a law for another exponent
            continue
        found, names = set(), instance.outputs
        for k in range(750):
            instance.step((k + 1) / 256)
            before, state = instance.get(names), instance.fmu.getFMUstate()
            for name in ("joint[1].torque", "joint[2].torque"):
                instance.set({name: -5.0})
                pairs = zip(names, before, instance.get(names), strict=True)
                found |= {n for n, a, b in pairs if abs(b - a) > 1e-8 * max(1.0, abs(a))}
                instance.fmu.setFMUstate(state)
            instance.fmu.freeFMUstate(state)
        changed[law] = sorted(found)
        instance.close()
    return changed


def test_dependencies_are_true_under_every_law(native, clean):
    root = description(native["pinned_arm"])
    names = [node.get("name") for node in root.iter("ScalarVariable")]
    declared = {
        names[int(unknown.get("index")) - 1]
        for unknown in root.find("ModelStructure/Outputs")
        if unknown.get("dependencies")
    }
    changed = clean(responses, native["pinned_arm"], len(CONTACT_LAWS))
    assert len(changed) >= len(CONTACT_LAWS) - 1
    for law, found in changed.items():
        assert set(found) <= declared, law
        assert "link[2].angular_acceleration" in found
    rigid = changed[str(CONTACT_LAWS["newton_impact"].number)]
    assert "contact[2].x_max.force" in rigid


@pytest.mark.full("more cases", but=21)
@every_model
def test_documents(fmus, target, model):
    """A page with every variable, the license, and a picture."""
    with zipfile.ZipFile(fmus[model]) as fmu:
        page = fmu.read("documentation/index.html").decode()
        assert fmu.read("documentation/licenses/license.txt").startswith(b"MIT License")
        name = "terminalsAndIcons/icon.png" if target == "fmi3" else "model.png"
        picture = pyplot.imread(io.BytesIO(fmu.read(name)), "png")
    assert all(f"<td>{variable.name}</td>" in page for variable in Model(load_scene(model)).variables)
    assert all(text in page for text in map(escape, STATUS_TEXT.values()))
    assert picture.shape == (128, 128, 3)
    assert 0.01 < np.mean(picture.min(axis=2) < 0.9) < 0.3


@pytest.mark.full("more cases", but=8)
@every_model
def test_both_kinds_for_fmi2_have_the_same_description(all_fmus, model):
    both = [description(all_fmus[target][model]) for target in ("pythonfmu", "native")]
    for root in both:
        del root.attrib["guid"], root.attrib["generationTool"]
        del root.find("CoSimulation").attrib["canNotUseMemoryManagementFunctions"]
    first, second = ([(n.tag, n.attrib, (n.text or "").strip()) for n in root.iter()] for root in both)
    assert first == second


# --- what can go wrong -----------------------------------------------------------------------------------


@pytest.mark.parametrize("platforms", [(), ("linux64", "amiga")])
def test_an_unknown_platform_is_refused(tmp_path, target, platforms):
    with pytest.raises(BuildError, match=r"platforms = .* must be some of linux64, win64"):
        build_fmu("rod_drop", tmp_path, **KINDS[target], platforms=platforms)


def test_an_unknown_target_is_refused(tmp_path):
    with pytest.raises(BuildError, match=r"target = 'fortran' must be one of pythonfmu, native"):
        build_fmu("rod_drop", tmp_path, target="fortran")


def test_versions_that_there_are_not_are_refused(tmp_path):
    with pytest.raises(BuildError, match=r"fmi = 1 must be one of 2, 3"):
        build_fmu("rod_drop", tmp_path, fmi=1)
    with pytest.raises(BuildError, match=r"makes FMUs for FMI 2\.0 only: FMI 3\.0 needs target = 'native'"):
        build_fmu("rod_drop", tmp_path, target="pythonfmu", fmi=3)
    assert not list(tmp_path.iterdir())


@pytest.mark.full("more cases", but=1)
def test_an_invalid_fmu_does_not_appear(tmp_path, monkeypatch, fmus):
    monkeypatch.setattr(build, "validate_fmu", lambda _path: ["no good", "at all"])
    with pytest.raises(BuildError, match=r"RodDrop\.fmu is not valid: no good; at all"):
        build_fmu("rod_drop", tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.full("more cases", but=1)
def test_the_folder_is_made(tmp_path, fmus):
    assert build_fmu("rod_drop", tmp_path / "a" / "b") == tmp_path / "a" / "b" / "RodDrop.fmu"
    assert [path.name for path in (tmp_path / "a" / "b").iterdir()] == ["RodDrop.fmu"]


@pytest.mark.full("takes long")
def test_where_the_fmu_is_a_link_nothing_else_is_left_in_its_folder(tmp_path):
    """What a link points to is written in place, as /dev/stdout is."""
    folder, kept = tmp_path / "folder", tmp_path / "kept.fmu"
    folder.mkdir()
    (folder / "RodDrop.fmu").symlink_to(kept)
    for _ in range(2):
        assert validate_fmu(build_fmu("rod_drop", folder)) == []
    assert [one.name for one in folder.iterdir()] == ["RodDrop.fmu"]
    assert kept.is_file()
