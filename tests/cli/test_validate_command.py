"""`chain-impact validate`: what it says, as text and as JSON, and its exit codes."""

import json
import zipfile


def test_validate_of_a_good_fmu(run, fmu):
    code, said, errors = run("validate", fmu)
    first, second = said.splitlines()
    assert (code, first, errors) == (0, f"{fmu}: no problems found", "")
    assert second.startswith(f"{fmu}: reference results: passed, ")


def test_validate_names_each_problem(run, here, fmu):
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile("odd.fmu", "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content = content.replace(b'name="gravity.x"', b'name="gravity.y"')
                content = content.replace(b'unit="kg"', b'unit="stone"')
            new.writestr(name, content)
    code, said, errors = run("validate", "odd.fmu")
    assert (code, errors) == (1, "")
    assert "gravity.y" in said
    assert "stone" in said
    assert "no problems found" not in said


def test_validate_says_as_json_what_it_says_in_words(run, here, fmu):
    code, said, errors = run("validate", fmu, "--json")
    found = json.loads(said)
    assert (code, errors, found["fmu"], found["findings"]) == (0, "", str(fmu), [])
    assert found["notes"][0].startswith("reference results: passed, ")
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile("odd.fmu", "w") as new:
        for name in old.namelist():
            new.writestr(name, old.read(name).replace(b'unit="kg"', b'unit="stone"'))
    code, said, errors = run("validate", "odd.fmu", "--json")
    assert (code, errors) == (1, "")
    found = json.loads(said)
    assert found["notes"] == []
    assert found["findings"][0] == {
        "text": "unit = 'stone' must be defined in UnitDefinitions",
        "file": "modelDescription.xml",
        "variable": "link[1].mass",
        "attribute": "unit",
    }
    assert len(found["findings"]) == len(run("validate", "odd.fmu")[1].splitlines())
