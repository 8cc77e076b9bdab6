"""`info`: values and variables, lists, and where it prints."""

# Tests: cli/info.py

import os
import re
import subprocess
import sys
import zipfile

import pytest

from chain_impact import CONTACT_LAWS, load_scene
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.files.models import model_names, models_folder
from chain_impact.variables.prepared import PreparedScene
from tests.cli.results import program

ROD = models_folder() / "rod_drop"


def info(run, source):
    """Return the text with the values, and name → line of each variable, joined with its indented lines."""
    code, output, errors = run("info", source)
    assert (code, errors) == (0, "")
    values, listing = output.split("\nVariables of the FMU\n")
    head, *rows = listing.splitlines()
    assert head.split() == ["name", "causality", "variability", "unit", "meaning"]
    assert max(map(len, rows)) <= 80
    full_lines = re.sub(r"\n +", " ", "\n".join(rows)).splitlines()
    return values, {line.split()[0]: line for line in full_lines}


FACTS = {
    "pinned_arm": """PinnedArm  Two-link arm pinned at the origin
  contact.points = [1, 2]  # derived: all that move
  link[2].mass = 0.6
  link[2].center_of_mass = 0.2  # derived: length / 2
  box.x_max = 0.3""",
    "four_link_box": """FourLinkBox  Four-link chain, free base
  FMI version = 2.0
  platforms = linux64
  simulation.stop_time = 2.0
  link[2].mass = 1.0
  contact.model = zhang_sharf""",
}


@pytest.mark.parametrize("scene", FACTS)
def test_info_has_values_and_every_variable(run, fmu, scene):
    values, lines = info(run, fmu if scene == "four_link_box" else scene)
    first, *rest = FACTS[scene].splitlines()
    assert values.startswith(first)
    assert {*rest} <= {*values.splitlines()}
    assert scene != "pinned_arm" or "x_min" not in values
    variables = PreparedScene(load_scene(scene)).variables
    assert lines.keys() == {variable.name for variable in variables}
    for variable in variables:
        line = lines[variable.name]
        assert line.split()[1:3] == [variable.causality, variable.variability]
        assert variable.description.partition(": 0 no fault")[0] in line


def test_each_number_of_a_status_has_its_own_line(run):
    _, output, _ = run("info", "rod_drop")
    lines = output[output.index("status of the solver\n") :].splitlines()
    numbered_lines = [line for line in lines if re.match(r" {6}\d", line)]
    assert [line.split()[:3] for line in numbered_lines[:3]] == [
        [str(code), *STATUS_TEXT[code].split()[:2]] for code in range(3)
    ]


@pytest.mark.full("more cases", but="scene")
def test_values_that_info_prints_can_be_set(run, source):
    lines = info(run, source)[0].splitlines()[1:]
    assignments = [
        line.strip().replace(" = ", "=", 1) for line in lines if re.search(r"[\[.]", line.split("=")[0])
    ]
    settings = [part for setting in assignments for part in ("--set", setting)]
    assert len(assignments) > 30
    assert run("simulate", source, *settings) == run("simulate", source)


def test_info_lists_models_and_laws(run):
    for list_name, names in (("models", model_names()), ("laws", CONTACT_LAWS)):
        code, output, _ = run("info", "--list", list_name)
        assert code == 0
        assert [line.split()[0] for line in output.splitlines()] == list(names)
        assert all(len(line.split()) > 2 for line in output.splitlines())


def test_a_console_without_unicode_gets_question_marks(run, work_folder):
    text, odd = (ROD / "scene.toml").read_text("utf-8"), 'description = "[bold] λ [/] b"'
    (work_folder / "odd.toml").write_text(re.sub('description = ".*"', odd, text), encoding="utf-8")
    assert run("info", "odd.toml")[1].startswith("RodDrop  [bold] λ [/] b\n")
    process = program("info", "odd.toml", env=os.environ | {"PYTHONIOENCODING": "ascii:strict"})
    assert (process.returncode, process.stderr) == (0, "")
    assert process.stdout.startswith("RodDrop  [bold] ? [/] b\n")


@pytest.mark.full("takes long")
def test_info_into_a_closed_pipe_is_quiet(fmu):
    """A pipe into `head -1` closes before all lines are printed."""
    for source in ("rod_drop", str(fmu)):
        command = [sys.executable, "-m", "chain_impact.cli", "info", source]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            process.stdout.close()
            assert process.stderr.read() == b""


def test_an_array_of_another_tool_has_a_list_of_start_values(run, work_folder):
    text = """<?xml version="1.0"?>
<fmiModelDescription fmiVersion="3.0" modelName="Other" instantiationToken="{0}" generationTool="another">
  <CoSimulation modelIdentifier="other"/>
  <TypeDefinitions>
    <EnumerationType name="Law">
      <Item name="hertz" value="1"/>
      <Item name="flores" value="2"/>
    </EnumerationType>
  </TypeDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="list" valueReference="1" causality="parameter" variability="fixed" start="1 2 3">
      <Dimension start="3"/>
    </Float64>
    <Float64 name="one" valueReference="2" causality="parameter" variability="fixed" start="2.50"/>
    <Enumeration name="laws" valueReference="3" causality="parameter" variability="fixed" declaredType="Law"
                 start="2 1">
      <Dimension start="2"/>
    </Enumeration>
    <Enumeration name="law" valueReference="4" causality="parameter" variability="fixed" declaredType="Law"
                 start="2"/>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"""
    with zipfile.ZipFile(work_folder / "other.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", text)
    code, output, errors = run("info", "other.fmu")
    assert (code, errors) == (0, "")
    assert {"  list = 1 2 3", "  one = 2.5", "  laws = 2 1", "  law = flores"} <= {*output.splitlines()}


def test_texts_of_a_scene_are_printed_unchanged(run, work_folder):
    text = "swing [bold]b[/bold] [red] of :car: :b: :100:"
    scene = (ROD / "scene.toml").read_text(encoding="utf-8")
    described = scene.replace("Uniform rod dropped at a tilt onto a floor", text)
    (work_folder / "rod.toml").write_text(described, encoding="utf-8")
    code, output, _ = run("info", "rod.toml")
    assert code == 0
    assert output.splitlines()[0] == f"RodDrop  {text}"
    _, output, _ = run("simulate", "rod.toml", "--curves", "energy.total", "--plot", "run:100:[bold].svg")
    assert "run:100:[bold].svg" in output
    _, _, errors = run("sweep", "rod.toml", "--vary", f"contact.restitution={text}", "-o", "all.csv")
    assert text in errors
