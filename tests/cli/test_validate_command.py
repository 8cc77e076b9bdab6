"""`chain-impact validate`: its reports as text and as JSON, and its exit codes."""

# Tests: cli/validate.py

import json
import zipfile

import pytest

from chain_impact.system import HOST


def test_validate_of_a_good_fmu(run, fmu):
    code, said, errors = run("validate", fmu)
    first, second = said.splitlines()
    assert (code, first, errors) == (0, f"{fmu}: no problems found", "")
    assert second.startswith(f"{fmu}: reference results: passed, ")


def odd(fmu, *changes):
    """Return an FMU in whose model description each pair of ``changes`` replaces a text by another."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile("odd.fmu", "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                for right, wrong in changes:
                    content = content.replace(right, wrong)
            new.writestr(name, content)
    return "odd.fmu"


def test_validate_says_as_json_what_it_says_in_words(run, here, fmu):
    code, said, errors = run("validate", fmu, "--json")
    found = json.loads(said)
    assert (code, errors, found["fmu"], found["findings"]) == (0, "", str(fmu), [])
    assert found["notes"][0].startswith("reference results: passed, ")
    code, said, errors = run(
        "validate", odd(fmu, (b'"gravity.x"', b'"gravity.y"'), (b'unit="kg"', b'unit="stone"')), "--json"
    )
    found = json.loads(said)
    assert (code, errors, found["notes"]) == (1, "", [])
    (stone,) = (
        finding
        for finding in found["findings"]
        if "stone" in finding["text"] and finding["variable"] == "link[1].mass"
    )
    assert stone["text"].startswith('The unit "stone" of variable "link[1].mass" (line ')
    assert stone["file"] == "modelDescription.xml"
    code, said, errors = run("validate", "odd.fmu")
    assert (code, errors, len(said.splitlines())) == (1, "", len(found["findings"]))
    assert all(word in said for word in ("gravity.y", "stone"))
    assert "no problems found" not in said


def test_quiet_leaves_only_faults(run, here, fmu):
    assert run("validate", fmu, "--quiet") == (0, "", "")
    spoiled = odd(fmu, (b'unit="kg"', b'unit="stone"'))
    _, said, _ = run("validate", spoiled)
    code, quiet, errors = run("validate", spoiled, "--quiet")
    assert (code, quiet) == (1, "")
    assert errors == "".join(f"chain-impact: {line}\n" for line in said.splitlines())


def test_a_file_that_is_no_whole_zip_is_a_finding(run, here, fmu):
    (here / "half.fmu").write_bytes(fmu.read_bytes()[:2000])
    code, said, errors = run("validate", "half.fmu", "--json")
    (found,) = json.loads(said)["findings"]
    assert (code, errors) == (1, "")
    assert run("validate", "half.fmu") == (1, f"half.fmu: {found['text']}\n", "")
    assert found["text"].startswith("not a readable FMU: ")


def test_a_description_that_fmpy_cannot_read_is_no_fault_of_the_binary(run, here, fmu):
    far = odd(fmu, (b'<Outputs>\n      <Unknown index="', b'<Outputs>\n      <Unknown index="9999'))
    code, said, errors = run("validate", far)
    index, reader = said.splitlines()
    assert (code, errors) == (1, "")
    assert all(line.startswith(f"{far}: modelDescription.xml: ") for line in (index, reader))
    assert "index = '9999" in index
    assert "IndexError" in reader


def test_several_fmus_are_all_checked(run, here, fmu):
    (here / "half.fmu").write_bytes(fmu.read_bytes()[:2000])
    code, said, errors = run("validate", "half.fmu", fmu)
    assert (code, errors, [line.split(": ")[0] for line in said.splitlines()]) == (
        1,
        "",
        ["half.fmu", str(fmu), str(fmu)],
    )
    assert run("validate", fmu, "nowhere.fmu")[:2] == (2, "")
    assert len(json.loads(run("validate", "half.fmu", "half.fmu", "--json")[1])) == 2
    code, said, errors = run("validate", "half.fmu", fmu, "--json")
    assert (code, errors) == (1, "")
    assert [(one["fmu"], len(one["findings"])) for one in json.loads(said)] == [
        ("half.fmu", 1),
        (str(fmu), 0),
    ]


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        (["binaries/nowhere64/a.so"], "it has folders for nowhere64"),
        (["binaries/"], "its folder binaries is empty"),
        (["binaries/linux64/", "binaries/win64/"], "its folder binaries is empty"),
        ([], "it has no folder binaries"),
    ],
)
def test_an_fmu_without_a_binary_for_this_machine_says_what_it_has(run, here, fmu, kept, said):
    """Both simulate and validate name the available platforms."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(here / "other.fmu", "w") as new:
        for name in old.namelist():
            if not name.startswith("binaries/"):
                new.writestr(name, old.read(name))
        for name in kept:
            new.writestr(name, "")
    said = f"so there is no binary for {HOST}: {said}\n"
    code, _, errors = run("simulate", "other.fmu")
    assert (code, errors.endswith(said)) == (3, True)
    code, found, _ = run("validate", "other.fmu")
    assert (code, found.endswith(said)) == (1, True)
