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
from chain_impact.fmu.importer import read_fmu
from chain_impact.fmu.validate import validation
from chain_impact.scene.reading import SceneError
from chain_impact.system import HOST
from tests.fmu.planted_faults import BINARIES, BINARY, FMI2, FMI3, XML, edited, said, spoiled

# --- sound FMUs ------------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize("model", ["rod_drop", "kneed_leg", "controlled_arm"])
def test_nothing_is_found_in_an_fmu_of_ours(fmus, model):
    found = validation(fmus[model])
    assert list(found.findings) == []
    assert [note.split(",")[0] for note in found.notes] == ["experiment default: passed"]


@pytest.mark.full("takes long")
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


@pytest.mark.full("more cases", but=4)
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

FAULTS = [(kind, *entry) for kind, table in (("native", FMI2), ("fmi3", FMI3)) for entry in table.items()]


@pytest.mark.full("more cases", but=10)
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
    with pytest.raises(SceneError, match=r"x\.fmu: not a readable FMU: extra/bomb\.csv: its 4\.29 GB"):
        read_fmu(path)
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


def test_an_fmu_for_scheduled_execution_is_not_run(fmi3, tmp_path):
    change = edited(
        (r"<CoSimulation modelIdentifier=(\S+)[^>]*>", r"<ScheduledExecution modelIdentifier=\1/>")
    )
    found = validation(spoiled(fmi3["rod_drop"], tmp_path / "x.fmu", change))
    assert [note for note in found.notes if note.startswith("not run: ")]
