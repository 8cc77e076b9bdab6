"""Faults planted in FMUs of ours, each of which is found with its place; and no fault in sound ones."""

import os
import re
import shutil
import struct
import subprocess
import sys
import textwrap
import zipfile
from pathlib import Path

import pytest

from chain_impact.fmu import archive
from chain_impact.fmu.build import validate_fmu
from chain_impact.fmu.validate import validation
from chain_impact.system import HOST, PLATFORMS
from tests.fmu.zig import zig

XML = "modelDescription.xml"
SUFFIX = PLATFORMS[HOST].suffix
BINARIES = {"fmi3": f"binaries/{PLATFORMS[HOST].fmi3}/RodDrop{SUFFIX}"}
BINARY = f"binaries/{HOST}/RodDrop{SUFFIX}"


def spoiled(fmu, target, change):
    """Write an FMU anew: ``change`` gets name and content of each file, and gives content or None."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            content = change(name, old.read(name))
            if content is not None:
                new.writestr(name, content)
    return target


def edited(*pairs):
    """A change of the model description: each pattern, which must be there, and what takes its place."""

    def change(name, content):
        text = content.decode() if name == XML else ""
        for pattern, new in pairs if text else ():
            text, count = re.subn(pattern, new, text, flags=re.DOTALL)
            assert count, pattern
        return text.encode() if text else content

    return change


def variable(name, pattern, new):
    """A change within the element of a variable of FMI 2.0 or 3.0."""
    return (
        rf'(name="{re.escape(name)}"[^\n]*(?:\n *<(?:Real|Integer|Enumeration)[^\n]*)?){pattern}',
        rf"\1{new}",
    )


def said(path, **options):
    found = validation(path, **options)
    return [str(finding) for finding in found.findings]


# --- sound FMUs ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["rod_drop", "kneed_leg", "controlled_arm"])
def test_nothing_is_found_in_an_fmu_of_ours(fmus, model):
    found = validation(fmus[model])
    assert list(found.findings) == []
    assert [note.split(",")[0] for note in found.notes] == ["experiment default: passed"]


def test_the_workflow_of_the_docs_finds_what_is_wrong(native, tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "check_fmus.md").read_text(encoding="utf-8")
    script = textwrap.dedent(re.search(r"```yaml.*?        run: \|\n(.*?)```", page, re.DOTALL)[1])
    command = tmp_path / "chain-impact"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m chain_impact.cli "$@"\n')
    command.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}

    def checked():
        shell = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script]
        done = subprocess.run(
            shell, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        return done.returncode, done.stdout

    assert checked() == (1, "")  # a folder without FMUs is no success
    (tmp_path / "fmus" / "deep").mkdir(parents=True)
    shutil.copy(native["rod_drop"], tmp_path / "fmus" / "deep" / "good one.fmu")
    code, lines = checked()
    assert (code, lines.splitlines()[0]) == (0, "fmus/deep/good one.fmu: no problems found")
    spoiled(native["rod_drop"], tmp_path / "fmus" / "odd.fmu", edited(*FMI2["start out of range"][0]))
    assert checked()[0] == 1


# --- faults of each kind of FMU ---------------------------------------------------------------------------


@pytest.mark.parametrize("fault", ["guid", "no binary", "garbage", "no resources"])
def test_faults_of_the_whole_are_found(fmus, target, tmp_path, fault):
    binary = BINARIES.get(target, BINARY)

    def change(name, content):
        if fault == "guid" and name == XML:
            return re.sub(rb'((guid|instantiationToken)=")........', rb"\g<1>00000000", content)
        if name == binary and fault in ("no binary", "garbage"):
            return None if fault == "no binary" else b"garbage"
        return None if fault == "no resources" and name.startswith("resources/") else content

    (line,) = said(spoiled(fmus["rod_drop"], tmp_path / "x.fmu", change))
    in_table = fault == "guid" and target == "pythonfmu"
    assert line.startswith("modelDescription.xml: guid: guid = 00000000-" if in_table else f"{binary}: ")
    sentence = {
        "guid": "is not that of resources/model.json" if in_table else "Instantiate gives no instance: ",
        "no binary": f"so there is no binary for {HOST}: it has no binary at all",
        "garbage": "the loader fails: ",
        # pythonfmu's wrapper reads a file without a look whether it is there
        "no resources": "crashes the process: " if target == "pythonfmu" else "gives no instance: ",
    }
    assert sentence[fault] in line


# --- faults of the model description ---------------------------------------------------------------------

FMI2 = {
    "min > max": (
        [variable("link[1].mass", r'min="0.0"', 'min="9.0" max="8.0"')],
        "link[1].mass: min: min = 9 must not be above max = 8",
    ),
    "start out of range": (
        [variable("link[1].mass", r'min="0.0"', 'min="0.75"')],
        "link[1].mass: start: start = 0.5 is below min = 0.75",
    ),
    "start of an enumeration": (
        [variable("contact.model", r'start="7"', 'start="70"')],
        "contact.model: start: start = 70 is none of the values of the enumeration",
    ),
    "start other than the FMU's own": (
        [variable("link[1].mass", r'start="0.5"', 'start="0.51"')],
        "link[1].mass: start: start = 0.51, and the FMU itself starts with 0.5",
    ),
    "one reference, two parameters": (
        [variable("link[1].mass", r'valueReference="\d+"', 'valueReference="0"')],
        "link[1].mass: valueReference: valueReference = 0 is that of gravity.x, too, and both can be set",
    ),
    "one reference, two units": (
        [
            variable(f"point[0].{name}", r'valueReference="\d+"', 'valueReference="7000"')
            for name in ("x", "vx")
        ],
        "point[0].vx: valueReference: valueReference = 7000 is that of point[0].x, too, and their units differ",
    ),
    "a reference that the FMU does not know": (
        [variable("point[0].x", r'valueReference="\d+"', 'valueReference="99999"')],
        "point[0].x: cannot be read as 1 Real: fmi2GetReal fails: ",
    ),
    "an index of the outputs": (
        [(r'<Outputs>(\s*)<Unknown index="\d+"', r'<Outputs>\1<Unknown index="99999"')],
        "ModelStructure/Outputs: index = '99999' must be an index from 1 to ",
    ),
    "a dependency": (
        [
            (
                r'<InitialUnknowns>(\s*)<Unknown index="(\d+)"',
                r'<InitialUnknowns>\1<Unknown index="\2" dependencies="0"',
            )
        ],
        "ModelStructure/InitialUnknowns, index ",
    ),
    "numbers of kinds": (
        [
            (
                r'<InitialUnknowns>(\s*)<Unknown index="(\d+)"',
                r'<InitialUnknowns>\1<Unknown index="\2" dependencies="1 2" dependenciesKind="dependent"',
            )
        ],
        "there are 2 dependencies, and 1 in dependenciesKind",
    ),
    "an output twice": (
        [(r'<Outputs>(\s*)(<Unknown index="\d+"[^\n]*)', r"<Outputs>\1\2\1\2")],
        " stands there 2 times",
    ),
    "an initial unknown too few": (
        [(r'<InitialUnknowns>\s*<Unknown index="\d+" ?/>', "<InitialUnknowns>")],
        "InitialUnknowns does not contain the expected set of variables",
    ),
    "a declared type": (
        [variable("link[1].mass", r'declaredType="Mass"', 'declaredType="Weight"')],
        "link[1].mass: declaredType: declaredType = 'Weight' must be defined in TypeDefinitions",
    ),
    "a unit": (
        [variable("link[1].mass", r'unit="kg"', 'unit="stone"')],
        "link[1].mass: unit: unit = 'stone' must be defined in UnitDefinitions",
    ),
    "a display unit": (
        [variable("link[1].mass", r'unit="kg"', 'unit="kg" displayUnit="stone"')],
        "link[1].mass: displayUnit: displayUnit = 'stone' must be defined in UnitDefinitions for the unit 'kg'",
    ),
    "an output that leaves its range": (
        [variable("point[0].y", r'unit="m"', 'unit="m" max="-5.0"')],
        "point[0].y: is ",
    ),
    "a name twice": (
        [('"gravity.x"', '"gravity.y"')],
        'gravity.y: The variable name "gravity.y" (line ',
    ),
    "no start": (
        [variable("link[1].mass", r' start="0.5"', "")],
        'link[1].mass: Variable "link[1].mass" (line ',
    ),
    "a start of an output": (
        [variable("point[0].x", r'unit="m"', 'unit="m" start="1.0"')],
        "point[0].x: The variable",
    ),
    "causality": (
        [variable("link[1].mass", '"fixed"', '"constant"')],
        "link[1].mass: The combination causality=",
    ),
    "XML": ([("</ModelStructure>", "")], "modelDescription.xml: is no XML: "),
    "schema": ([("<CoSimulation ", '<CoSimulation more="1" ')], "modelDescription.xml: "),
    "version": (
        [('fmiVersion="2.0"', 'fmiVersion="1.0"')],
        "fmiVersion: fmiVersion = '1.0' must be one of 2.0, 3.0",
    ),
}
FMI3 = {
    "min > max": FMI2["min > max"],
    "start out of range": FMI2["start out of range"],
    "start other than the FMU's own": FMI2["start other than the FMU's own"],
    "a unit": FMI2["a unit"],
    "one reference": (
        [variable("link[1].mass", r'valueReference="\d+"', 'valueReference="0"')],
        'link[1].mass: Variable "link[1].mass" ',
    ),
    "an array of another size": (
        [(r'(name="link.angle" [^\n]*\s*)<Dimension start="1"', r'\1<Dimension start="2"')],
        "link.angle: cannot be read as 2 Float64: fmi3GetFloat64 fails: ",
    ),
    "starts of an array": (
        [
            (
                r'(name="link.angle" [^\n]*)initial="calculated"([^>]*>\s*)<Dimension start="1"',
                r'\1initial="exact" start="0 0 0"\2<Dimension start="1"',
            )
        ],
        "link.angle: start: there are 3 values, and the dimensions make 1",
    ),
    "a dimension": (
        [(r'(name="link.angle" [^\n]*\s*)<Dimension start="1"', r'\1<Dimension valueReference="99999"')],
        "link.angle: Dimension: valueReference = '99999' must be the value reference of a variable",
    ),
    "an output that is not there": (
        [(r'<Output valueReference="\d+"', '<Output valueReference="99999"')],
        "ModelStructure/Output: valueReference = '99999' must be the value reference of a variable",
    ),
    "a dependency": (
        [
            (
                r'<InitialUnknown valueReference="(\d+)"',
                r'<InitialUnknown valueReference="\1" dependencies="99999"',
            )
        ],
        "dependencies: '99999' must be the value reference of a variable",
    ),
    "a derivative": (
        [(r'derivative="136"', 'derivative="99999"')],
        "point.velocity: derivative: derivative = '99999' must be the value reference of a variable",
    ),
}
FAULTS = [(kind, *entry) for kind, table in (("native", FMI2), ("fmi3", FMI3)) for entry in table.items()]


@pytest.mark.parametrize(
    ("kind", "fault", "case"), FAULTS, ids=[f"{kind} {name}" for kind, name, _ in FAULTS]
)
def test_a_planted_fault_is_found_with_its_place(all_fmus, tmp_path, kind, fault, case):
    pairs, sentence = case
    lines = said(spoiled(all_fmus[kind]["rod_drop"], tmp_path / "x.fmu", edited(*pairs)))
    assert any(sentence in line for line in lines), lines
    assert all(re.match(r"(modelDescription\.xml|binaries/\S+): \S", line) for line in lines)
    assert all(len(line.split()) > 4 for line in lines)


def test_an_alias_is_no_fault(native, tmp_path):
    """Two outputs of one value, with one unit, are what FMI 2.0 calls an alias."""

    def change(name, content):
        if name != XML:
            return content
        text = content.decode()
        reference = re.search(r'name="point\[0\]\.x" valueReference="(\d+)"', text)[1]
        return re.sub(r'(name="point\[1\]\.x" valueReference=")\d+', rf"\g<1>{reference}", text).encode()

    lines = said(spoiled(native["rod_drop"], tmp_path / "x.fmu", change))
    assert not [line for line in lines if "valueReference" in line]


# --- the zip ---------------------------------------------------------------------------------------------


def test_a_bomb_is_refused_by_its_declared_sizes(native, tmp_path, monkeypatch):
    path = spoiled(native["rod_drop"], tmp_path / "x.fmu", lambda name, content: content)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as fmu:
        fmu.writestr("extra/bomb.csv", bytes(1000))
    raw = path.read_bytes()
    # the central directory says how large it is, unpacked
    at = raw.rindex(b"extra/bomb.csv") - 46
    assert raw[at : at + 4] == b"PK\1\2"
    path.write_bytes(raw[: at + 24] + struct.pack("<I", 4_294_000_000) + raw[at + 28 :])
    (line,) = said(path)
    assert line.startswith("extra/bomb.csv: its 4.29 GB, unpacked, make the FMU 4.29 GB: nothing is unpacked")
    assert validate_fmu(path) == [line]
    monkeypatch.setattr(archive, "LARGEST", 10**10)
    assert archive.archive_findings(path) == []


@pytest.mark.parametrize(
    "name",
    ["../x", "extra/../../x", "/etc/x", "C:/x", "resources\\x"],
    ids=["up", "inner", "root", "drive", "slash"],
)
def test_a_path_that_leaves_the_folder_is_refused(native, tmp_path, name):
    path = spoiled(native["rod_drop"], tmp_path / "x.fmu", lambda name, content: content)
    with zipfile.ZipFile(path, "a") as fmu:
        fmu.writestr(name, b"")
    (line,) = said(path)
    assert line.startswith(f"{name}: the path ")


# --- binaries that do not come back ----------------------------------------------------------------------

SOURCE = """
#include <stdlib.h>
void *fmi2Instantiate(void) { %s }
"""
NAMES = [
    "fmi2GetTypesPlatform",
    "fmi2GetVersion",
    "fmi2SetDebugLogging",
    "fmi2FreeInstance",
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2Terminate",
    "fmi2Reset",
    "fmi2GetReal",
    "fmi2GetInteger",
    "fmi2GetBoolean",
    "fmi2GetString",
    "fmi2SetReal",
    "fmi2SetInteger",
    "fmi2SetBoolean",
    "fmi2SetString",
    "fmi2GetFMUstate",
    "fmi2SetFMUstate",
    "fmi2FreeFMUstate",
    "fmi2SerializedFMUstateSize",
    "fmi2SerializeFMUstate",
    "fmi2DeSerializeFMUstate",
    "fmi2GetDirectionalDerivative",
    "fmi2SetRealInputDerivatives",
    "fmi2GetRealOutputDerivatives",
    "fmi2DoStep",
    "fmi2CancelStep",
    "fmi2GetStatus",
    "fmi2GetRealStatus",
    "fmi2GetIntegerStatus",
    "fmi2GetBooleanStatus",
    "fmi2GetStringStatus",
]


@pytest.mark.parametrize(
    ("body", "timeout", "sentence"),
    [
        ("abort();", 60.0, "fmi2Instantiate crashes the process: SIGABRT"),
        ("exit(7);", 60.0, "fmi2Instantiate ends the process, exit code 7"),
        ("for (volatile int i = 0;; i = !i) {}", 5.0, "fmi2Instantiate has not come back after 5 s"),
    ],
)
def test_a_binary_that_does_not_come_back_is_found(native, tmp_path, body, timeout, sentence):
    functions = "".join(f"int {name}(void) {{ return 3; }}\n" for name in NAMES)
    (tmp_path / "fmu.c").write_text(SOURCE % body + functions)
    zig(tmp_path, "-shared", "-fPIC", "fmu.c", "-o", f"fmu{SUFFIX}")
    binary = (tmp_path / f"fmu{SUFFIX}").read_bytes()
    path = spoiled(
        native["rod_drop"], tmp_path / "x.fmu", lambda name, content: binary if name == BINARY else content
    )
    assert said(path, timeout=timeout) == [f"{BINARY}: {sentence}"]


def test_an_fmu_for_scheduled_execution_is_not_run(fmi3, tmp_path):
    change = edited(
        (r"<CoSimulation modelIdentifier=(\S+)[^>]*>", r"<ScheduledExecution modelIdentifier=\1/>")
    )
    found = validation(spoiled(fmi3["rod_drop"], tmp_path / "x.fmu", change))
    assert [note for note in found.notes if note.startswith("not run: ")]
