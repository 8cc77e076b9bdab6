"""The model description and the files of an FMU for FMI 3.0, by the standard's section 2.4."""

import io
import zipfile
from importlib.metadata import version
from pathlib import Path

import fmpy
import numpy as np
import pytest
from lxml import etree

from chain_impact import build_fmu, load_scene
from chain_impact.fmu.model_description import model_description
from chain_impact.scene.scene import model_names
from chain_impact.variables.model import Model
from chain_impact.variables.table import word_index
from tests.fmu.conftest import KINDS
from tests.fmu.contents import description

every_model = pytest.mark.parametrize("model", model_names())


@every_model
def test_the_description_keeps_the_schema_of_the_standard(fmi3, model):
    folder = Path(fmpy.__file__).with_name("schema") / "fmi3"
    schema = etree.XMLSchema(etree.parse(folder / "fmi3ModelDescription.xsd"))
    with zipfile.ZipFile(fmi3[model]) as fmu:
        root = etree.parse(io.BytesIO(fmu.read("modelDescription.xml")))
    schema.assertValid(root)


@every_model
def test_variables_are_those_of_fmi2_and_time_and_arrays(fmi3, model):
    scene = load_scene(model)
    instance, variables = Model(scene).new_instance(), Model(scene).variables
    nodes = list(description(fmi3[model]).find("ModelVariables"))
    assert [int(node.get("valueReference")) for node in nodes] == list(range(len(nodes)))
    types = {"real": "Float64", "integer": "Int64", "enumeration": "Enumeration"}
    for node, variable in zip(nodes, variables, strict=False):
        assert (node.get("name"), node.tag) == (variable.name, types[variable.type])
        assert node.get("causality") == variable.causality
        assert node.get("variability") == variable.variability
        assert (node.get("start") is None) == (variable.causality == "output")
        if variable.causality != "output":
            words = instance.view("f8" if variable.type == "real" else "i8")
            assert float(node.get("start")) == words[word_index(instance.dtype, variable.place)]
    time, *arrays = nodes[len(variables) :]
    assert (time.get("name"), time.get("causality")) == ("time", "independent")
    assert arrays
    by_name = {node.get("name"): node for node in nodes}
    for node in arrays:
        first, _, last = node.get("description").removeprefix("array of ").partition(" to ")
        element = by_name[first]
        kept = ("unit", "min", "max", "nominal", "variability")
        assert all(node.get(key) == element.get(key) for key in kept)
        assert last in by_name or np.prod([int(size.get("start")) for size in node]) == 1
    of = {node.get("name"): node.get("derivative") for node in nodes if node.get("derivative")}
    names = [node.get("name") for node in nodes]
    assert names[int(of["point.velocity"])] == "point.position"
    assert names[int(of["point[0].ax"])] == "point[0].vx"


def test_the_structure_names_every_output_and_what_acts_at_once(fmi3):
    root = description(fmi3["pinned_arm"])
    nodes = {node.get("valueReference"): node for node in root.find("ModelVariables")}
    outputs = [number for number, node in nodes.items() if node.get("causality") == "output"]
    for part in ("Output", "InitialUnknown"):
        assert [unknown.get("valueReference") for unknown in root.iter(part)] == outputs
    for unknown in root.iter("Output"):
        name = nodes[unknown.get("valueReference")].get("name")
        on = [nodes[number].get("name") for number in unknown.get("dependencies").split()]
        at_once = name.endswith((".ax", ".ay", "acceleration", "force"))
        at_once &= not name.startswith("point[0]")  # the base is pinned
        assert on == (["joint[1].torque", "joint[2].torque"] if at_once else []), name


def test_files_and_capabilities(fmi3):
    names = zipfile.ZipFile(fmi3["rod_drop"]).namelist()
    assert [name for name in names if not name.startswith("extra/")] == [
        "binaries/x86_64-linux/RodDrop.so",
        "documentation/index.html",
        "documentation/licenses/license.txt",
        "modelDescription.xml",
        "resources/model.bin",
        "terminalsAndIcons/icon.png",
    ]
    assert description(fmi3["rod_drop"]).find("CoSimulation").attrib == {
        "modelIdentifier": "RodDrop",
        "needsExecutionTool": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "canHandleVariableCommunicationStepSize": "true",
        "mightReturnEarlyFromDoStep": "true",
        "hasEventMode": "true",
    }


@pytest.mark.parametrize("fmi", [2, 3])
def test_whose_the_model_is_only_the_scene_says(fmi):
    said = {
        "author": "Jane Doe",
        "copyright": "© 2026 Example <Ltd>",
        "license": "CC-BY-4.0",
        "version": "1.2",
    }
    scene = load_scene("rod_drop")
    for values in ({}, said, {"author": "Jane Doe"}):
        root = model_description(Model(scene.with_values(values)), "a tool", fmi)
        assert {name: root.get(name) for name in said if name in root.attrib} == values
        assert root.get("generationTool") == "a tool"


def test_the_author_is_in_fmus_of_both_targets(tmp_path, target):
    scene = load_scene("rod_drop").with_values({"author": "Jane Doe", "version": "1.2"})
    root = description(build_fmu(scene, tmp_path, **KINDS[target]))
    assert (root.get("author"), root.get("version")) == ("Jane Doe", "1.2")
    assert root.get("generationTool").startswith(f"chain-impact {version('chain-impact')}")
