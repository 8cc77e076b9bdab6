"""`chain-impact validate`: its reports as text and as JSON, and its exit codes."""

# Tests: cli/validate.py

import json
import zipfile

import pytest

from chain_impact.system import HOST


def test_validate_of_a_good_fmu(run, fmu):
    code, output, errors = run("validate", fmu)
    first, second = output.splitlines()
    assert (code, first, errors) == (0, f"{fmu}: no problems found", "")
    assert second.startswith(f"{fmu}: reference results: passed, ")


def odd(fmu, *changes):
    """Return an FMU in whose model description each pair of ``changes`` replaces a text by another."""
    with zipfile.ZipFile(fmu) as source_zip, zipfile.ZipFile("odd.fmu", "w") as target_zip:
        for name in source_zip.namelist():
            content = source_zip.read(name)
            if name == "modelDescription.xml":
                for old_text, new_text in changes:
                    content = content.replace(old_text, new_text)
            target_zip.writestr(name, content)
    return "odd.fmu"


def test_validate_says_as_json_what_it_says_in_words(run, work_folder, fmu):
    code, output, errors = run("validate", fmu, "--json")
    report = json.loads(output)
    assert (code, errors, report["fmu"], report["findings"]) == (0, "", str(fmu), [])
    assert report["notes"][0].startswith("reference results: passed, ")
    code, output, errors = run(
        "validate", odd(fmu, (b'"gravity.x"', b'"gravity.y"'), (b'unit="kg"', b'unit="stone"')), "--json"
    )
    report = json.loads(output)
    assert (code, errors, report["notes"]) == (1, "", [])
    (stone,) = (
        finding
        for finding in report["findings"]
        if "stone" in finding["text"] and finding["variable"] == "link[1].mass"
    )
    assert stone["text"].startswith('The unit "stone" of variable "link[1].mass" (line ')
    assert stone["file"] == "modelDescription.xml"
    code, output, errors = run("validate", "odd.fmu")
    assert (code, errors, len(output.splitlines())) == (1, "", len(report["findings"]))
    assert all(word in output for word in ("gravity.y", "stone"))
    assert "no problems found" not in output


def test_quiet_leaves_only_faults(run, work_folder, fmu):
    assert run("validate", fmu, "--quiet") == (0, "", "")
    spoiled = odd(fmu, (b'unit="kg"', b'unit="stone"'))
    _, output, _ = run("validate", spoiled)
    code, quiet, errors = run("validate", spoiled, "--quiet")
    assert (code, quiet) == (1, "")
    assert errors == "".join(f"chain-impact: {line}\n" for line in output.splitlines())


def test_a_file_that_is_no_whole_zip_is_a_finding(run, work_folder, fmu):
    (work_folder / "half.fmu").write_bytes(fmu.read_bytes()[:2000])
    code, output, errors = run("validate", "half.fmu", "--json")
    (finding,) = json.loads(output)["findings"]
    assert (code, errors) == (1, "")
    assert run("validate", "half.fmu") == (1, f"half.fmu: {finding['text']}\n", "")
    assert finding["text"].startswith("not a readable FMU: ")


def test_a_description_that_fmpy_cannot_read_is_no_fault_of_the_binary(run, work_folder, fmu):
    odd_fmu = odd(fmu, (b'<Outputs>\n      <Unknown index="', b'<Outputs>\n      <Unknown index="9999'))
    code, output, errors = run("validate", odd_fmu)
    index, reader = output.splitlines()
    assert (code, errors) == (1, "")
    assert all(line.startswith(f"{odd_fmu}: modelDescription.xml: ") for line in (index, reader))
    assert "index = '9999" in index
    assert "IndexError" in reader


def test_several_fmus_are_all_checked(run, work_folder, fmu):
    (work_folder / "half.fmu").write_bytes(fmu.read_bytes()[:2000])
    code, output, errors = run("validate", "half.fmu", fmu)
    assert (code, errors, [line.split(": ")[0] for line in output.splitlines()]) == (
        1,
        "",
        ["half.fmu", str(fmu), str(fmu)],
    )
    assert run("validate", fmu, "nowhere.fmu")[:2] == (2, "")
    assert len(json.loads(run("validate", "half.fmu", "half.fmu", "--json")[1])) == 2
    code, output, errors = run("validate", "half.fmu", fmu, "--json")
    assert (code, errors) == (1, "")
    assert [(report["fmu"], len(report["findings"])) for report in json.loads(output)] == [
        ("half.fmu", 1),
        (str(fmu), 0),
    ]


@pytest.mark.parametrize(
    ("names_in_zip", "ending"),
    [
        (["binaries/nowhere64/a.so"], "it has folders for nowhere64"),
        (["binaries/"], "its folder binaries is empty"),
        (["binaries/linux64/", "binaries/win64/"], "its folder binaries is empty"),
        ([], "it has no folder binaries"),
    ],
)
def test_an_fmu_without_a_binary_for_this_machine_says_what_it_has(
    run, work_folder, fmu, names_in_zip, ending
):
    with zipfile.ZipFile(fmu) as source_zip, zipfile.ZipFile(work_folder / "other.fmu", "w") as target_zip:
        for name in source_zip.namelist():
            if not name.startswith("binaries/"):
                target_zip.writestr(name, source_zip.read(name))
        for name in names_in_zip:
            target_zip.writestr(name, "")
    ending = f"so there is no binary for {HOST}: {ending}\n"
    code, _, errors = run("simulate", "other.fmu")
    assert (code, errors.endswith(ending)) == (3, True)
    code, output, _ = run("validate", "other.fmu")
    assert (code, output.endswith(ending)) == (1, True)
