"""`chain-impact validate`: what it says, as text and as JSON, and its exit codes."""

import json
import zipfile


def test_validate_of_a_good_fmu(run, fmu):
    code, said, errors = run("validate", fmu)
    first, second = said.splitlines()
    assert (code, first, errors) == (0, f"{fmu}: no problems found", "")
    assert second.startswith(f"{fmu}: reference results: passed, ")


def odd(fmu):
    """Two variables of one name, and a unit that there is not."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile("odd.fmu", "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content = content.replace(b'"gravity.x"', b'"gravity.y"').replace(
                    b'unit="kg"', b'unit="stone"'
                )
            new.writestr(name, content)
    return "odd.fmu"


def test_validate_says_as_json_what_it_says_in_words(run, here, fmu):
    code, said, errors = run("validate", fmu, "--json")
    found = json.loads(said)
    assert (code, errors, found["fmu"], found["findings"]) == (0, "", str(fmu), [])
    assert found["notes"][0].startswith("reference results: passed, ")
    code, said, errors = run("validate", odd(fmu), "--json")
    found = json.loads(said)
    assert (code, errors, found["notes"]) == (1, "", [])
    (stone,) = (
        one for one in found["findings"] if "stone" in one["text"] and one["variable"] == "link[1].mass"
    )
    assert stone["text"].startswith('The unit "stone" of variable "link[1].mass" (line ')
    assert stone["file"] == "modelDescription.xml"
    code, said, errors = run("validate", "odd.fmu")
    assert (code, errors, len(said.splitlines())) == (1, "", len(found["findings"]))
    assert all(word in said for word in ("gravity.y", "stone"))
    assert "no problems found" not in said
