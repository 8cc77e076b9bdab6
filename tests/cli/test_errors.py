"""Refusals of the command line, each with one line: wrong arguments, values, places, scenes and FMUs."""

# Tests: cli/options_in_errors.py, cli/options.py, cli/source.py

import errno
import os
import re
import shlex
import zipfile
from functools import partial
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib import pyplot

from chain_impact import model_names
from chain_impact.cli import parser
from chain_impact.cli.options_in_errors import typed_options, with_option
from chain_impact.extras import MissingExtraError
from chain_impact.scene.errors import RefusalError, SceneError

SCENES = {
    "half": "name = ",
    "name": 'name = "A"',
    "zero": "\0",
    "floor": 'name = "A"\n[floor]\ny = 0',
    "links": 'name = "[/]"\n[chain]\nlinks = 3',
}
SEVEN = ("x", "y", "vx", "vy", "angle[1]", "angle[2]", "angle[3]")
WORDS = {
    "long": 300 * "a",
    "free": "--free contact.stiffness,contact.restitution",
    "seven": " ".join(f"--vary 'initial.{name}=1'" for name in SEVEN),
}


def refusals():
    """Yield exit code, verb, arguments and message for each verb of each line of refused.txt."""
    for line in Path(__file__).with_name("refused.txt").read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            code, verbs, arguments, message = (part.strip() for part in line.split("|"))
            yield from ((int(code), verb, arguments, message) for verb in verbs.split(","))


def wrong(run, work_folder, code, pattern, *arguments):
    """Return a list with the failed refusal, or an empty list.

    A good refusal prints one matching line and leaves no file.
    """
    files_before = sorted(work_folder.rglob("*"))
    result_code, _, errors = run(*arguments)
    is_right_message = re.fullmatch(r"chain-impact[^\n]*: [^\n]+\n", errors) and re.search(pattern, errors)
    is_refused = (result_code, bool(is_right_message), sorted(work_folder.rglob("*"))) == (
        code,
        True,
        files_before,
    )
    return [] if is_refused else [(arguments, result_code, errors)]


refused_value = partial(RefusalError, source="S")


def line_error(requirement):
    error = SceneError(requirement, name="a.b", value="2")
    error.line = 3
    return error


@pytest.fixture
def refused(run, work_folder):
    """Return a function that runs a command that must fail."""

    def refused(*case):
        assert wrong(run, work_folder, *case) == []

    return refused


@pytest.fixture
def files(work_folder, fmu):
    """Create obstructing files and folders, invalid scenes and invalid FMUs."""
    (work_folder / "file").write_text("")
    (work_folder / "t.csv").write_text(
        "t,point[0].x,point[0].y,point[1].x,point[1].y\n0,0,1,0,1\n1,0,1,0,1\n"
    )
    for name in ("folder.csv", "folder.png"):
        (work_folder / name).mkdir()
    (work_folder / "full.csv").symlink_to("/dev/full")
    for name, text in SCENES.items():
        (work_folder / f"{name}.toml").write_text(text)
    (work_folder / "impacts.csv").write_text("point,wall,onset,end\n4,y_min,0.1,0.2\n")
    (work_folder / "robot.urdf").write_text('<?xml version="1.0"?>\n<robot name="a"><link name="b"/></robot>')
    (work_folder / "quoted.csv").write_text('time,point[0].x\n"0,5","1,5"\n')
    (work_folder / "motion.csv").write_text("time,point[4].x\n0.1,2.4\n0.2,2.5\n")
    content = fmu.read_bytes()
    for name, data in {"empty": b"", "hello": b"hello", "half": content[: len(content) // 2]}.items():
        (work_folder / f"{name}.fmu").write_bytes(data)
    for name, entry in {"other": "hello.txt", "no_xml": "modelDescription.xml"}.items():
        with zipfile.ZipFile(work_folder / f"{name}.fmu", "w") as archive:
            archive.writestr(entry, "<hello")
    with zipfile.ZipFile(fmu) as source_zip, zipfile.ZipFile(work_folder / "tank.fmu", "w") as target_zip:
        for name in source_zip.namelist():
            target_zip.writestr(name, source_zip.read(name).replace(b'"link[', b'"tank['))


def test_commands_are_refused_with_the_listed_sentences(run, work_folder, files, fmu):
    failures = []
    for code, verb, arguments, message in refusals():
        for source in ("four_link_box", str(fmu)) if "{each}" in arguments else ("",):
            words = shlex.split(arguments.format(fmu=fmu, each=source, **WORDS))
            failures += wrong(run, work_folder, code, re.escape(message.format(**WORDS)), verb, *words)
    assert failures == []
    assert run("info", "tank.fmu")[0] == 0


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EROFS])
def test_an_fmu_that_cannot_be_written_names_it_and_nothing_is_left(refused, work_folder, monkeypatch, error):
    def writestr(*_, **__):
        raise OSError(error, os.strerror(error))

    (work_folder / "build").mkdir()
    monkeypatch.setattr(zipfile.ZipFile, "writestr", writestr)
    refused(2, rf"^chain-impact: build/RodDrop\.fmu: {os.strerror(error)}; [a-z]", "build", "rod_drop")


def test_a_disk_that_is_full_is_named_for_a_picture(refused, work_folder):
    (work_folder / "full.png").symlink_to("/dev/full")
    pattern = (
        r"^chain-impact: --plot full\.png: No space left on device; free some space, or write to another d"
    )
    refused(2, pattern, "simulate", "rod_drop", "--curves", "energy.total", "--plot", "full.png")


def test_an_extra_that_is_missing(refused, monkeypatch):
    def record(*_, **__):
        raise MissingExtraError("pandas cannot be imported: pip install 'chain-impact[pandas]'")

    monkeypatch.setattr("chain_impact.cli.source.Source.record", record)
    refused(2, r"pip install 'chain-impact\[pandas\]'$", "simulate")


def test_a_package_that_is_damaged(refused, monkeypatch):
    def record(*_, **__):
        raise ImportError("DLL load failed while importing lib: not a valid application", name="pyarrow.lib")

    monkeypatch.setattr("chain_impact.cli.source.Source.record", record)
    refused(2, "a package is damaged, install it anew: DLL load failed while importing lib", "simulate")


def test_options_of_windows_are_refused_before_a_run(refused, monkeypatch):
    monkeypatch.setattr("chain_impact.cli.source.Source.record", None)
    for name in ("out.bmpx", "out", "png"):
        refused(2, rf"{name} must end in \.png, \.svg, \.pdf", "simulate", "--plot", name)
    with mpl.rc_context({"backend": "agg"}):
        refused(3, "--show: there is no display.* use --plot FILE", "simulate", "--show")
        pyplot.close("all")

    def figure(**_):
        raise ImportError("Cannot load backend 'TkAgg' which requires the 'tk' interactive framework")

    monkeypatch.setattr(pyplot, "figure", figure)
    refused(3, "--show: Cannot load backend 'TkAgg'", "simulate", "--show")


@pytest.mark.parametrize("name", ["other.fmu", "no_xml.fmu"])
def test_validate_of_a_zip_without_a_description(run, files, name):
    code, output, errors = run("validate", name)
    assert (code, errors) == (1, "")
    pattern = rf"{re.escape(name)}: modelDescription\.xml: is (missing|no XML): [^\n]+\n"
    assert re.fullmatch(pattern, output)


def test_the_command_alone_shows_first_steps_that_can_be_typed(run):
    code, output, errors = run()
    assert (code, errors) == (2, "")
    steps = [re.split(r" {2,}", line.strip())[0] for line in output.splitlines() if line.startswith("  ")]
    assert len(steps) == 3
    for step in steps:
        assert parser().parse_args(step.split()[1:]).source in model_names()
    assert "chain-impact --help" in output


@pytest.mark.parametrize(
    "arguments",
    [
        "fit rod motion.csv --free contact.restitution -o rod/../rod/scene.toml",
        "fit rod motion.csv --free contact.restitution -o {here}/rod/scene.toml",
        "fit rod motion.csv,impacts.csv --free contact.restitution -o impacts.csv",
        "fit rod/scene.toml motion.csv --free contact.restitution -o rod/scene.toml",
    ],
)
def test_an_output_never_replaces_a_file_that_is_read(refused, work_folder, arguments):
    (work_folder / "rod").mkdir()
    files = [work_folder / name for name in ("rod/scene.toml", "motion.csv", "impacts.csv")]
    for file in files:
        file.write_text("as before", encoding="utf-8")
    refused(2, "is read by this command, and would be replaced", *arguments.format(here=work_folder).split())
    assert {file.read_text(encoding="utf-8") for file in files} == {"as before"}


def test_values_of_options_are_found_as_typed():
    words = ["sweep", "--threads=4", "--vary", "a=1", "--plot", "--show", "-o", "runs.csv"]
    options = ["--threads", "--vary", "-o"]
    assert typed_options(words, options) == [("--threads", "4"), ("--vary", "a=1"), ("-o", "runs.csv")]


@pytest.mark.parametrize(
    ("option", "value", "error", "message"),
    [
        (
            "--set",
            "a.b=2.0",
            refused_value("must be < 1", name="a.b", value="2"),
            "S: --set a.b=2.0 must be < 1",
        ),
        ("--vary", "a.b=0,2", refused_value("is", name="a.b", value="2"), "S: --vary a.b=0,2: a.b = 2 is"),
        (
            "--set",
            "a=[0,x]",
            refused_value("is", name="a[2]", value="'x'"),
            "S: --set a=[0,x]: a[2] = 'x' is",
        ),
        (
            "--stop-time",
            "-1",
            refused_value("is", name="simulation.stop_time", value="-1.0"),
            "S: --stop-time -1 is",
        ),
        ("--laws", "hertz,x", refused_value("is not a law", name="x"), "S: --laws x is not a law"),
        ("--sigma", "a=1%", refused_value(": none", name="a", argument="sigma"), "S: --sigma a=1%: none"),
        ("--sigma", "a=0", refused_value("is", name="a", argument="sigma", value="'0'"), "S: --sigma a=0 is"),
        ("--threads", "0", refused_value("is", argument="threads", value="0"), "S: --threads 0 is"),
        ("--plane", "x,x", refused_value(": is", argument="plane", value="x,x"), "S: --plane x,x: is"),
        ("-o", "no/a.csv", OSError("no/a.csv: No such folder"), "-o no/a.csv: No such folder"),
    ],
)
def test_an_error_tells_the_option_whose_value_it_refuses(option, value, error, message):
    assert with_option(error, [("--other", "c=1"), (option, value)]) == message


@pytest.mark.parametrize(
    "error",
    [
        line_error("must be < 1"),
        refused_value("leaves no tighter one", argument="check", name="a.b", value="2"),
        refused_value("is not a parameter; the nearest is a.b", name="c.d"),
        refused_value("is not a parameter", name="a.b.c"),
        refused_value("the value of a.b is missing"),
    ],
)
def test_an_error_on_something_else_names_no_option(error):
    assert with_option(error, [("--set", "a.b=2")]) == str(error)
