"""What the command line refuses, each time in one line: wrong arguments, values, places, scenes and FMUs."""

import errno
import os
import re
import zipfile

import matplotlib as mpl
import pytest
from matplotlib import pyplot

from chain_impact.cli import report
from chain_impact.extras import MissingExtraError
from chain_impact.scene.scene import model_names


@pytest.fixture
def refused(run, here):
    """Run a command that must fail with one line that matches, an exit code, and no file left behind."""

    def refused(code, pattern, *arguments):
        before = sorted(here.rglob("*"))
        found, _, said = run(*arguments)
        assert found == code
        assert re.fullmatch(r"chain-impact[^\n]*: [^\n]+\n", said), said
        assert re.search(pattern, said), said
        assert sorted(here.rglob("*")) == before

    return refused


@pytest.mark.parametrize(
    "arguments",
    [["fly"], ["build", "a", "b"], ["simulate", "--csv"], ["validate"], ["build", "--target", "fortran"]],
)
def test_wrong_arguments_are_said_in_one_line(refused, arguments):
    refused(2, r"; see chain-impact( \w+)? --help$", *arguments)


# --- build -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", ["file", "file/deeper", "/proc/nowhere"])
def test_build_into_what_is_no_folder(refused, here, place):
    (here / "file").write_text("")
    refused(2, place, "build", "rod_drop", "-o", place)


@pytest.mark.parametrize(
    ("place", "pattern"),
    [
        ("file", "file is a file, must be a folder"),
        ("mine.fmu", r"mine\.fmu must not end in \.fmu: it is a folder"),
        (300 * "a", "File name too long"),
    ],
)
def test_build_into_a_folder_that_cannot_be(refused, here, place, pattern):
    (here / "file").write_text("")
    refused(2, pattern, "build", "rod_drop", "-o", place)


def test_build_of_an_unknown_platform(refused):
    refused(2, "'amiga' is no platform; must be of linux64, win64", "build", "--platform", "linux64,amiga")


# --- parameters ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("setting", "pattern"),
    [
        ("contact.stifness=1e8", r"contact\.stifness is no parameter; the nearest is contact\.stiffness"),
        ("point[0].x=1", r"point\[0\]\.x is no parameter"),
        ("contact.stiffness=hard", r"contact\.stiffness = '?hard'? must be a .*number"),
        ("contact.model=no_law", r"contact\.model = '?no_law'? must be one of .*zhang_sharf"),
        ("contact.model=99", r"contact\.model = .*99.* must be one of"),
        ("contact.model=florez", r"contact\.model = '?florez'? must be one of .*; the nearest is flores$"),
        ("contact.model", "must be NAME=VALUE"),
        ("=3", "must be NAME=VALUE"),
        ("contact.stiffness=", "must be NAME=VALUE"),
    ],
)
@pytest.mark.parametrize("kind", ["scene", "FMU"])
def test_settings_that_cannot_be(refused, fmu, kind, setting, pattern):
    refused(2, pattern, "simulate", fmu if kind == "FMU" else "four_link_box", "--set", setting)


@pytest.mark.parametrize("value", ["-1", "0", "nan", "inf"])
def test_a_value_out_of_range(refused, fmu, value):
    pattern = r"contact\.stiffness = \S+ must be a finite number > 0 \[N/m\^exponent\]"
    refused(2, pattern, "simulate", "--set", f"contact.stiffness={value}")
    refused(3, pattern, "simulate", fmu, "--set", f"contact.stiffness={value}")


def test_a_start_inside_a_wall(refused, fmu):
    refused(
        2,
        r"point 0 at \(0\.6, 1\.4\) m is 0\.05 m deep in the wall x_min",
        "simulate",
        "--set",
        "box.x_min=0.65",
    )
    refused(3, "beyond a stop: point 0 at the wall x_min", "simulate", fmu, "--set", "box.x_min=0.65")


# --- files to write, and scenes --------------------------------------------------------------------------


@pytest.mark.parametrize("option", ["--csv", "--plot"])
@pytest.mark.parametrize("place", ["missing/out", "file/out", "folder"])
def test_a_place_that_cannot_be_written(refused, here, option, place):
    place += ".csv" if option == "--csv" else ".png"
    (here / "file").write_text("")
    (here / "folder.csv").mkdir()
    (here / "folder.png").mkdir()
    refused(2, rf"^chain-impact: {re.escape(place)}: [A-Z]", "simulate", "rod_drop", option, place)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("option", ["--csv", "--plot"])
def test_a_disk_that_is_full_is_named(refused, here, option):
    full = "full.csv" if option == "--csv" else "full.png"
    (here / full).symlink_to("/dev/full")
    refused(
        2,
        rf"^chain-impact: {full}: No space left on device; free some space, or write to another disk$",
        *("simulate", "rod_drop", option, full),
    )


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EROFS])
def test_an_fmu_that_cannot_be_written_names_it_and_nothing_is_left(refused, here, monkeypatch, error):
    def writestr(*_, **__):
        raise OSError(error, os.strerror(error))

    (here / "build").mkdir()
    monkeypatch.setattr(zipfile.ZipFile, "writestr", writestr)
    told = rf"^chain-impact: build/RodDrop\.fmu: {os.strerror(error)}; [a-z]"
    refused(2, told, "build", "rod_drop")


@pytest.mark.parametrize("kind", ["scene", "FMU"])
def test_a_result_that_is_too_large(refused, fmu, kind):
    source = fmu if kind == "FMU" else "four_link_box"
    pattern = r"simulation\.stop_time = 2 \[s\] in steps of simulation\.step_size = 1e-09 \[s\] gives"
    refused(2, pattern, "simulate", source, "--set", "simulation.step_size=1e-9")
    refused(2, "must be at most 2 GB", "simulate", source, "--stop-time", "2e5")


def test_an_extra_that_is_missing(refused, monkeypatch):
    def record(*_, **__):
        raise MissingExtraError("pandas cannot be imported: pip install 'chain-impact[pandas]'")

    monkeypatch.setattr(report, "record", record)
    refused(2, r"pip install 'chain-impact\[pandas\]'$", "simulate")


@pytest.mark.parametrize("name", ["out.bmpx", "out", "png"])
def test_an_unknown_kind_of_picture_is_refused_before_anything_runs(refused, monkeypatch, name):
    monkeypatch.setattr(report, "record", None)
    refused(2, rf"{name} must end in \.png, \.svg, \.pdf", "simulate", "--plot", name)


@pytest.mark.parametrize("verb", ["build", "simulate", "info"])
def test_an_unknown_scene(refused, verb):
    pattern = f"no_scene: cannot be read .*; must be a scene file, .* model: {', '.join(model_names())}"
    refused(2, pattern, verb, "no_scene")


@pytest.mark.parametrize("verb", ["build", "simulate", "info"])
@pytest.mark.parametrize("text", ["name = ", 'name = "A"', "\0", 'name = "[/]"\n[chain]\nlinks = 3'])
def test_a_scene_that_is_none(refused, here, verb, text):
    (here / "bad.toml").write_text(text)
    refused(2, r"bad\.toml: ", verb, "bad.toml")


# --- --show ----------------------------------------------------------------------------------------------


def test_show_without_a_display_says_so_before_anything_runs(refused, monkeypatch):
    monkeypatch.setattr(report, "record", None)
    with mpl.rc_context({"backend": "agg"}):
        refused(3, "--show: there is no display.* use --plot FILE", "simulate", "--show")
        pyplot.close("all")


def test_show_with_a_toolkit_that_is_not_there(refused, monkeypatch):
    def figure(**_):
        raise ImportError("Cannot load backend 'TkAgg' which requires the 'tk' interactive framework")

    monkeypatch.setattr(pyplot, "figure", figure)
    refused(3, "--show: Cannot load backend 'TkAgg'", "simulate", "--show")


# --- FMUs that are none ----------------------------------------------------------------------------------


@pytest.fixture(params=["empty", "no zip", "truncated", "a zip of something", "no XML"])
def broken(request, here, fmu):
    path = here / "broken.fmu"
    content = fmu.read_bytes()
    if request.param in ("a zip of something", "no XML"):
        name = "hello.txt" if request.param == "a zip of something" else "modelDescription.xml"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(name, "<hello")
    else:
        path.write_bytes(
            {"empty": b"", "no zip": b"hello", "truncated": content[: len(content) // 2]}[request.param]
        )
    return path.name


@pytest.mark.parametrize("verb", ["simulate", "info"])
def test_a_broken_fmu(refused, broken, verb):
    refused(2, r"broken\.fmu: not a readable FMU: \w+", verb, broken)


def test_validate_of_a_broken_fmu(run, refused, broken):
    if not zipfile.is_zipfile(broken):
        refused(2, r"broken\.fmu: not a readable FMU: \w+", "validate", broken)
        return
    code, said, errors = run("validate", broken)
    assert (code, errors) == (1, "")
    assert re.fullmatch(r"broken\.fmu: modelDescription\.xml: is (not in the FMU|no XML): [^\n]+\n", said)


@pytest.mark.parametrize("timeout", ["0", "nan", "inf", "soon"])
def test_validate_with_a_time_that_is_none(refused, fmu, timeout):
    refused(2, "--timeout", "validate", fmu, "--timeout", timeout)


def test_the_fmu_of_something_else(refused, run, here, fmu):
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile("tank.fmu", "w") as new:
        for name in old.namelist():
            new.writestr(name, old.read(name).replace(b'"link[', b'"tank['))
    refused(2, r"tank\.fmu: not the FMU of a chain", "simulate", "tank.fmu")
    assert run("info", "tank.fmu")[0] == 0


@pytest.mark.parametrize("verb", ["simulate", "info", "validate"])
def test_a_missing_fmu(refused, verb):
    refused(2, r"^chain-impact: missing\.fmu: No such file", verb, "missing.fmu")


# --- compare ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "pattern"),
    [
        (["four_link_box", "--set", "simulation.stop_time=0.1"], "no impact to compare the laws by"),
        (["four_link_box", "--set", "contact.model=99"], r"contact\.model = .*99.* must be one of"),
        (["four_link_box", "--csv", "nowhere/laws.csv"], "nowhere/laws.csv: No such folder"),
        (["four_link_box", "--plot", "laws.txt"], r"laws.txt must end in \.png"),
        (["no_scene"], "no_scene: cannot be read"),
    ],
)
def test_compare_of_what_cannot_be(refused, arguments, pattern):
    refused(2, pattern, "compare", *arguments)


def test_compare_takes_no_fmu(refused, fmu):
    refused(2, r"FourLinkBox.fmu: cannot be read \(it is a ZIP file, such as an FMU", "compare", fmu)


@pytest.mark.parametrize("verb", ["simulate", "compare"])
@pytest.mark.parametrize("file", ["laws.parquet", "laws.json", "laws.CSV.gz"])
def test_a_table_is_csv(refused, here, verb, file):
    refused(2, f"^chain-impact: --csv {file}: must end in .csv, as", verb, "rod_drop", "--csv", file)
    assert not (here / file).exists()


@pytest.mark.parametrize("option", ["--plot", "--csv"])
def test_an_option_with_one_value_is_not_given_twice(run, here, option):
    files = ("one.png", "two.png") if option == "--plot" else ("one.csv", "two.csv")
    code, said, errors = run("simulate", "rod_drop", option, files[0], option, files[1])
    assert (code, said) == (2, "")
    assert f"argument {option}: is given twice: give it once" in errors
    assert not any((here / file).exists() for file in files)


def test_the_command_alone_shows_the_help(run):
    code, said, errors = run()
    assert (code, errors) == (2, "")
    assert said == run("--help")[1]


# --- outputs -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", "rod", "--csv", "rod/scene.toml"],
        ["simulate", "rod/scene.toml", "--csv", "{here}/rod/scene.toml"],
        ["simulate", "rod.fmu", "--csv", "rod.fmu"],
        ["compare", "rod/scene.toml", "--csv", "rod/../rod/scene.toml"],
        ["fit", "rod", "motion.csv,impacts.csv", "--free", "contact.restitution", "-o", "impacts.csv"],
        ["fit", "rod/scene.toml", "motion.csv", "--free", "contact.restitution", "-o", "rod/scene.toml"],
    ],
)
def test_what_is_read_is_not_replaced(refused, here, arguments):
    (here / "rod").mkdir()
    files = [here / name for name in ("rod/scene.toml", "rod.fmu", "motion.csv", "impacts.csv")]
    for file in files:
        file.write_text("as before", encoding="utf-8")
    refused(2, "is read by this command, and would be replaced", *(a.format(here=here) for a in arguments))
    assert {file.read_text(encoding="utf-8") for file in files} == {"as before"}
