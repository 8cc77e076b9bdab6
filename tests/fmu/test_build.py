"""The content of an FMU: valid, complete, reproducible, small, and without other packages to install."""

# Tests: fmu/model_description.py, fmu/native_target.py, fmu/versions.py

import io
import zipfile
from html import escape
from importlib.metadata import version
from pathlib import Path
from xml.etree.ElementTree import tostring

import fmpy
import numpy as np
import pytest
from fmpy import validation
from lxml import etree
from matplotlib import pyplot

from chain_impact import load_scene
from chain_impact.compilation.errors import BuildError
from chain_impact.fmu import build
from chain_impact.fmu.build import build_fmu
from chain_impact.fmu.model_description import model_description
from chain_impact.fmu.references import REFERENCE_FILE
from chain_impact.fmu.scene_data import SCENE_DATA_FILE
from chain_impact.fmu.validate import validate_fmu
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.files.models import model_names
from chain_impact.variables.indices import word_index
from chain_impact.variables.prepared import PreparedScene
from tests.fmu.importer import Instance
from tests.fmu.interface import description
from tests.fmu.scenes import KINDS
from tests.helpers.tools.binaries import binary
from tests.helpers.tools.planted_faults import XML, edited, spoiled

MODELS = pytest.mark.parametrize(
    "model", ["elastic_ball", "bouncing_table", "cart_pole", "four_link_box", "kneed_leg", "thrown_brick"]
)
"""Models with few and many variables, with moving walls, a slider, stops, a body and friction."""
FMIS = {"native": 2, "fmi3": 3}
AT_ONCE = (".ax", ".ay", "angular_acceleration", "acceleration", "force")
"""Name endings of outputs that inputs change at once; forces are included, as rigid walls balance torques."""


@pytest.mark.full("more cases", but="native-rod_drop")
@pytest.mark.parametrize(
    "model", ["rod_drop", "four_link_box", "kneed_leg", "ramp", "sliding_rod", "controlled_arm"]
)
def test_fmpy_finds_nothing_wrong(strict, model, quick_names):
    """Only kinds with the C interface are checked: pythonfmu's FMU has the description of the native one."""
    assert validation.validate_fmu(strict[model]) == []
    assert validate_fmu(strict[model]) == []


@pytest.mark.full("more cases", but=1)
def test_a_name_is_judged_as_fmpy_does(native, tmp_path):
    names = {"9x": 1, "a b": 1, "link[1.mass": 1, "link[].mass": 1, "a..b": 1, "mäss": 1}
    for name, finding_count in (names | {"der(x)": 0, "'a b'": 0, "a_1[1,2].b": 0}).items():
        change = edited(('"initial.x"', f'"{name}"'), alone=True)
        findings = validate_fmu(spoiled(native["rod_drop"], tmp_path / "x.fmu", change))
        assert len(findings) == finding_count
        assert all(f"{name!r} is not a name of the naming convention" in text for text in findings)


@pytest.mark.full("more cases", but=["pythonfmu", "native"])
def test_an_fmu_has_equal_bytes_and_a_guid_of_its_values(fmus, target, tmp_path):
    path = Path(fmus["rod_drop"])
    assert build_fmu("rod_drop", tmp_path, **KINDS[target]).read_bytes() == path.read_bytes()
    values = {"contact.stiffness": 2e8, "author": "Jane Doe", "version": "1.2"}
    changed_description = description(
        build_fmu(load_scene("rod_drop").with_values(values), tmp_path, **KINDS[target])
    )
    name = "instantiationToken" if target == "fmi3" else "guid"
    assert None is not changed_description.get(name) != description(path).get(name) is not None
    assert (changed_description.get("author"), changed_description.get("version")) == ("Jane Doe", "1.2")
    assert changed_description.get("generationTool").startswith(f"chain-impact {version('chain-impact')}")


@pytest.mark.full("more cases", but=4)
@MODELS
def test_an_fmu_has_the_files_of_the_standard(fmus, target, model):
    """Files are sorted, undated and small: a page with every variable, the license, a picture, a binary."""
    path, name = Path(fmus[model]), load_scene(model).name
    assert path.name == f"{name}.fmu"
    assert path.stat().st_size < 2e6
    picture = "terminalsAndIcons/icon.png" if target == "fmi3" else "model.png"
    expected = {"documentation/index.html", "documentation/licenses/license.txt", picture, XML}
    expected |= {"terminalsAndIcons/terminalsAndIcons.xml"} if target == "fmi3" else set()
    with zipfile.ZipFile(path) as fmu:
        assert fmu.namelist() == sorted(fmu.namelist())
        assert {entry.date_time for entry in fmu.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        page = fmu.read("documentation/index.html").decode()
        assert all(
            f"<td>{variable.name}</td>" in page for variable in PreparedScene(load_scene(model)).variables
        )
        assert all(escape(text) in page for text in STATUS_TEXT.values())
        assert fmu.read("documentation/licenses/license.txt").startswith(b"MIT License")
        pixels = pyplot.imread(io.BytesIO(fmu.read(picture)), "png")
        if target != "pythonfmu":  # test_slave.py tests the files of pythonfmu's FMU
            library = f"binaries/{'x86_64-linux' if target == 'fmi3' else 'linux64'}/{name}.so"
            names = {file for file in fmu.namelist() if file not in {REFERENCE_FILE, SCENE_DATA_FILE}}
            assert names == expected | {library, "resources/model.bin"}
            assert binary(fmu.read(library)).libraries == {"libc.so.6", "libm.so.6"}
            assert f"fmi{FMIS[target]}DoStep" in binary(fmu.read(library)).offered
            assert fmu.getinfo(library).file_size < 540e3
    assert pixels.shape == (128, 128, 4)
    assert 0.01 < np.mean(pixels[..., :3].min(axis=2) < 0.9) < 0.3


# --- the model description -------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=["elastic_ball", "bouncing_table"])
@MODELS
def test_the_description_is_that_of_the_scene_for_both_kinds_of_fmi2(all_fmus, model):
    roots = [description(all_fmus[target][model]) for target in ("pythonfmu", "native")]
    for root in roots:
        del root.attrib["guid"], root.attrib["generationTool"]
        del root.find("CoSimulation").attrib["canNotUseMemoryManagementFunctions"]
    first, second = ([(n.tag, n.attrib, (n.text or "").strip()) for n in root.iter()] for root in roots)
    assert first == second


@pytest.fixture(scope="module", params=FMIS.values())
def descriptions(request):
    """Return the version of FMI, and model → (attributes and tag of each variable; the model description)."""
    by_model = {}
    for model in model_names():
        root = model_description(PreparedScene(load_scene(model)), "a tool", request.param)
        nodes = list(root.find("ModelVariables"))
        attributes = [
            dict(n.attrib) if request.param == 3 else dict(n.attrib) | dict(n[0].attrib) for n in nodes
        ]
        tags = [n.tag if request.param == 3 else n[0].tag for n in nodes]
        by_model[model] = {n["name"]: n | {"tag": tag} for n, tag in zip(attributes, tags, strict=True)}, root
    return request.param, by_model


def test_variables_and_starts_are_those_of_the_scene_to_the_last_bit(descriptions):
    fmi, by_model = descriptions
    tags = {"real": "Float64", "integer": "Int64"} if fmi == 3 else {"real": "Real", "integer": "Integer"}
    for model, (nodes, _) in by_model.items():
        prepared_scene = PreparedScene(load_scene(model))
        instance = prepared_scene.new_instance()
        for (name, node), variable in zip(nodes.items(), prepared_scene.variables, strict=fmi == 2):
            assert (name, node["tag"]) == (variable.name, tags.get(variable.type, "Enumeration"))
            assert (node["causality"], node["variability"]) == (variable.causality, variable.variability)
            assert node.get("unit", "") == variable.unit
            if variable.causality == "output":
                assert "start" not in node
            else:
                words = instance.view("f8" if variable.type == "real" else "i8")
                assert float(node["start"]) == words[word_index(instance.dtype, variable.record_path)]


def test_units_types_unknowns_and_ranges_are_complete(descriptions):
    fmi, by_model = descriptions
    for nodes, root in by_model.values():
        assert root.get("generationDateAndTime").endswith("Z")
        assert root.get("variableNamingConvention") == "structured"
        units = {unit.get("name") for unit in root.iter("Unit")}
        types = {element.get("name") for element in root.find("TypeDefinitions")}
        for node in nodes.values():
            assert "unit" in node or node["tag"] not in ("Real", "Float64")
            assert node.get("unit") in {*units, None}
            plain = node["tag"] in ("Integer", "Int64") or node.get("name") == "time"
            assert plain or node.get("declaredType") in types
            assert float(node.get("nominal", 1)) > 0
        outputs = [node for node in nodes.values() if node["causality"] == "output"]
        places = [list(nodes).index(node["name"]) + (fmi == 2) for node in outputs]
        parts = ("Output", "InitialUnknown") if fmi == 3 else ("Outputs/Unknown", "InitialUnknowns/Unknown")
        for part in parts:
            unknowns = root.iter(part) if fmi == 3 else root.find("ModelStructure").iterfind(part)
            assert [
                int(element.get("valueReference" if fmi == 3 else "index")) for element in unknowns
            ] == places
        assert float(nodes["energy.kinetic"]["min"]) == 0.0
        assert nodes["impact.last_point"]["min"] == "-1"
        assert nodes["solver.status"]["max"] == str(max(STATUS_TEXT))
        assert nodes["link[1].mass"]["description"].endswith("; must be > 0")


def test_rates_name_what_they_are_the_rate_of(descriptions):
    fmi, by_model = descriptions
    for nodes, _ in by_model.values():
        names = list(nodes)
        rates = {n: names[int(v["derivative"]) - (fmi == 2)] for n, v in nodes.items() if "derivative" in v}
        expected_rates = {"point[1].ay": "point[1].vy", "point[0].vx": "point[0].x"}
        expected_rates["link[1].angular_acceleration"] = "link[1].angular_velocity"
        expected_rates["link[1].angular_velocity"] = "link[1].angle"
        if fmi == 3:
            expected_rates["point.velocity"] = "point.position"
        assert expected_rates.items() <= rates.items()
        ends = (".vx", ".vy", ".ax", ".ay", ".angular_velocity", ".angular_acceleration")
        outputs = [n for n, v in nodes.items() if v["causality"] == "output" and n.endswith(ends)]
        assert [name for name in rates if name in outputs] == outputs


@pytest.mark.parametrize("exponent", [1.0, 1.5, 3.0])
def test_the_nominal_depth_and_force_are_those_of_one_energy(exponent):
    """The energy is that of the mass m at one length L per second: K δ^(n+1)/(n+1) = m L²/2, F = K δ^n."""
    changes = {"contact.exponent": exponent, "contact.model": "hunt_crossley"}
    scene = load_scene("rod_drop").with_values(changes)
    nodes = {
        n.get("name"): n[0]
        for n in model_description(PreparedScene(scene), "a tool", 2).iter("ScalarVariable")
    }
    names = [f"contact[0].y_min.{name}" for name in ("penetration", "force")]
    depth, force = (float(nodes[name].get("nominal")) for name in names)
    stiffness = scene.contact.stiffness
    assert force == pytest.approx(stiffness * depth**exponent, rel=1e-9)
    energy = stiffness * depth ** (exponent + 1.0) / (exponent + 1.0)
    assert energy == pytest.approx(float(nodes["energy.total"].get("nominal")) / 2.0, rel=1e-9)


def test_the_description_keeps_the_schema_of_the_standard(descriptions):
    fmi, by_model = descriptions
    folder = Path(fmpy.__file__).with_name("schema") / f"fmi{fmi}"
    schema = etree.XMLSchema(etree.parse(folder / f"fmi{fmi}ModelDescription.xsd"))
    for _, root in by_model.values():
        schema.assertValid(etree.fromstring(tostring(root)))


def test_arrays_are_what_their_elements_are(descriptions):
    fmi, by_model = descriptions
    for nodes, root in by_model.values() if fmi == 3 else ():
        references = [int(n.get("valueReference")) for n in root.find("ModelVariables")]
        assert references == list(range(len(nodes)))
        assert nodes["time"]["causality"] == "independent"
        arrays = [n for n in root.find("ModelVariables") if len(n) and n.find("Dimension") is not None]
        assert arrays
        for node in arrays:
            first, _, last = node.get("description").removeprefix("array of ").partition(" to ")
            keys = ("unit", "min", "max", "nominal", "variability")
            assert all(node.get(key) == nodes[first].get(key) for key in keys)
            sizes = [int(size.get("start")) for size in node.iter("Dimension")]
            assert last in nodes or np.prod(sizes) == 1


def test_inputs_act_at_once_on_accelerations_and_forces_only(descriptions):
    fmi, by_model = descriptions
    nodes, root = by_model["pinned_arm"]
    names, key = list(nodes), "valueReference" if fmi == 3 else "index"
    outputs = root.iter("Output") if fmi == 3 else root.find("ModelStructure/Outputs")
    for output in outputs:
        name = names[int(output.get(key)) - (fmi == 2)]
        on = [names[int(number) - (fmi == 2)] for number in output.get("dependencies").split()]
        at_once = name.endswith(AT_ONCE) and not name.startswith("point[0]")  # the base is pinned
        assert on == (["joint[1].torque", "joint[2].torque"] if at_once else []), name


CAPABILITIES = {"modelIdentifier": "RodDrop", "needsExecutionTool": "false"}
CAPABILITIES |= {"canBeInstantiatedOnlyOncePerProcess": "false"}
CAPABILITIES |= {"canHandleVariableCommunicationStepSize": "true"}


def test_an_fmu_declares_its_capabilities(fmus, target):
    states = "FMUState" if target == "fmi3" else "FMUstate"
    of_fmi2 = {"canInterpolateInputs": "false"}
    of_fmi2["canNotUseMemoryManagementFunctions"] = "true" if target == "pythonfmu" else "false"
    of_fmi3 = {"mightReturnEarlyFromDoStep": "true", "hasEventMode": "true"}
    of_states = {f"canGetAndSet{states}": "true", f"canSerialize{states}": "true"}
    expected = CAPABILITIES | of_states | (of_fmi3 if target == "fmi3" else of_fmi2)
    assert description(fmus["rod_drop"]).find("CoSimulation").attrib == expected


@pytest.mark.parametrize("fmi", [2, 3])
def test_whose_the_model_is_only_the_scene_says(fmi):
    texts = {
        "author": "Jane Doe",
        "copyright": "© 2026 Example <Ltd>",
        "license": "CC-BY-4.0",
        "version": "1",
    }
    for values in ({}, texts, {"author": "Jane Doe"}):
        root = model_description(PreparedScene(load_scene("rod_drop").with_values(values)), "a tool", fmi)
        assert {name: root.get(name) for name in texts if name in root.attrib} == values
        assert root.get("generationTool") == "a tool"


def ranges(fmu):
    """Return the smallest and the largest value of each output in a run, and the limits that it has."""
    instance = Instance(fmu).start()
    rows = instance.run([0.002 * (i + 1) for i in range(1000)])
    limits = {name: instance.variables[name] for name in instance.outputs}
    columns = zip(instance.outputs, zip(*rows, strict=True), strict=True)
    return [[name, min(values), max(values), limits[name].min, limits[name].max] for name, values in columns]


def test_outputs_keep_their_ranges(fmus, clean):
    rows = clean(ranges, fmus["four_link_box"])
    for name, low, high, minimum, maximum in rows:
        assert minimum is None or low >= float(minimum), name
        assert maximum is None or high <= float(maximum), name
    assert len([minimum for *_, minimum, _ in rows if minimum is not None]) > 5


def responses(fmu, laws):
    """Return, for each law that can start, the outputs that an input changes at once at any time of a run.

    Smaller changes than the solver's tolerance do not count: the solver puts points at rest back onto a rigid
    wall when it starts anew.
    """
    outputs_of_laws, settings = {}, {"gravity.x": 9.81, "gravity.y": 0.0}
    settings |= {"link[1].joint_damping": 2.0, "link[2].joint_damping": 2.0}
    for law in range(1, laws + 1):
        instance = Instance(fmu)
        try:
            instance.start(**settings, **{"contact.model": law})
        except Exception:  # a law with another exponent
            continue
        changed_outputs, names = set(), instance.outputs
        for k in range(375):
            instance.step((k + 1) / 128)
            values, state = instance.get(names), instance.fmu.getFMUstate()
            for name in ("joint[1].torque", "joint[2].torque"):
                instance.set({name: -5.0})
                pairs = zip(names, values, instance.get(names), strict=True)
                changed_outputs |= {n for n, a, b in pairs if abs(b - a) > 1e-8 * max(1.0, abs(a))}
                instance.fmu.setFMUstate(state)
            instance.fmu.freeFMUstate(state)
        outputs_of_laws[law] = sorted(changed_outputs)
        instance.close()
    return outputs_of_laws


@pytest.mark.full("takes long")
def test_dependencies_are_true_under_every_law(native, clean):
    outputs = fmpy.read_model_description(native["pinned_arm"]).outputs
    declared = {output.variable.name for output in outputs if output.dependencies}
    outputs_of_laws = clean(responses, native["pinned_arm"], len(CONTACT_LAWS))
    assert len(outputs_of_laws) >= len(CONTACT_LAWS) - 1
    for law, changed_outputs in outputs_of_laws.items():
        assert set(changed_outputs) <= declared, law
        assert "link[2].angular_acceleration" in changed_outputs
    assert "contact[2].x_max.force" in outputs_of_laws[str(CONTACT_LAWS["newton_impact"].number)]


# --- what can go wrong -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"platforms": ()}, r"platforms = .* must be some of linux64, win64"),
        ({"platforms": ("linux64", "amiga"), "target": "native"}, r"platforms = .* must be some of"),
        ({"target": "fortran"}, "target = 'fortran' must be one of pythonfmu, native"),
        ({"fmi": 1}, "fmi = 1 must be one of 2, 3"),
        ({"target": "pythonfmu", "fmi": 3}, r"for FMI 2\.0 only: FMI 3\.0 needs target = 'native'"),
    ],
)
def test_an_fmu_that_cannot_be_built_is_refused(tmp_path, options, message):
    with pytest.raises(BuildError, match=message):
        build_fmu("rod_drop", tmp_path, **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.full("more cases", but=1)
def test_an_invalid_fmu_does_not_appear(tmp_path, monkeypatch, native):
    monkeypatch.setattr(build, "validate_fmu", lambda _path: ["no good", "at all"])
    with pytest.raises(BuildError, match=r"RodDrop\.fmu is not valid: no good; at all"):
        build_fmu("rod_drop", tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.full("takes long")
def test_an_fmu_that_is_a_link_leaves_no_other_file_in_its_folder(tmp_path):
    """The target of a link is written in place, as /dev/stdout is; a missing folder is made."""
    folder, linked_file = tmp_path / "a" / "folder", tmp_path / "kept.fmu"
    assert build_fmu("rod_drop", folder) == folder / "RodDrop.fmu"
    (folder / "RodDrop.fmu").unlink()
    (folder / "RodDrop.fmu").symlink_to(linked_file)
    for _ in range(2):
        assert validate_fmu(build_fmu("rod_drop", folder)) == []
    assert [file.name for file in folder.iterdir()] == ["RodDrop.fmu"]
    assert linked_file.is_file()
