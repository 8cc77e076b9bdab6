"""The commands of the command line, and their messages when a run fails midway."""

# Tests: cli/simulate.py, cli/compare.py, cli/convert.py, cli/cache.py, cli/__main__.py

import csv
import json
import re
import shlex
import warnings
from importlib import import_module
from importlib.metadata import version

import matplotlib as mpl
import pytest
from matplotlib import pyplot

from chain_impact import CONTACT_LAWS, cli, load_scene, simulate
from chain_impact.cli import info
from chain_impact.fmu.run import record_fmu
from chain_impact.simulation import instance
from chain_impact.studies.accuracy import differences
from chain_impact.variables.prepared import PreparedScene
from tests.cli.results import PNG, impact_lines, program, read_csv

LITTLE_WORK = "solver.work_limit=1500"  # work units: enough for the first flight, too few for the impacts


# --- simulate --------------------------------------------------------------------------------------------


@pytest.mark.full("takes long")
def test_simulate_prints_the_same_of_a_scene_and_of_its_fmu(run, fmu):
    scene, of_fmu = run("simulate"), run("simulate", fmu)
    assert (scene[0], scene[2]) == (of_fmu[0], of_fmu[2]) == (0, "")
    assert impact_lines(scene[1]) == impact_lines(of_fmu[1])
    assert len(impact_lines(scene[1])) == 14


@pytest.mark.filterwarnings("default")
def test_a_warning_of_another_package_is_one_line_without_its_code(run, monkeypatch):
    def warned():
        warnings.warn("a glyph is missing", UserWarning, stacklevel=1)
        return {"a": "b"}

    monkeypatch.setitem(info.LISTS, "laws", warned)
    code, _, errors = run("info", "--list", "laws")
    assert (code, errors) == (0, "chain-impact: warning: a glyph is missing\n")


def test_simulate_prints_the_largest_force_in_a_joint(run):
    output = run("simulate", "pinned_arm", "--set", "outputs.loads=true")[1]
    places = [r"669\.89\d N in joint\[2\]", r"[\d.]+ N in joint\[1\]"]
    lines = [
        rf"^{head} +at most {place}, at .* during impact 1$"
        for head, place in zip(("loads", ""), places, strict=True)
    ]
    assert re.search("\n".join(lines).replace("\n^", "\n"), output, re.M)
    (row,) = impact_lines(output)
    assert (row[6], row[8:]) == ("1016", ["669.9", "2"])
    output_without_loads = run("simulate", "pinned_arm")[1]
    assert "loads" not in output_without_loads
    assert len(impact_lines(output_without_loads)[0]) == 8


@pytest.mark.full("more cases", but="scene")
def test_check_estimates_the_errors_by_a_second_run(run, source):
    code, output, errors = run(
        "simulate", source, "--check", "--stop-time", "0.6", "--set", "solver.tolerance=1e-7"
    )
    assert (code, errors) == (0, "")
    (line,) = [line for line in output.splitlines() if line.startswith("check ")]
    runs = [simulate("four_link_box", 0.6, tolerance=tolerance) for tolerance in (1e-7, 1e-8)]
    expected = differences(*runs)
    for text in (f"{expected.onset:.1e} s", "(2 impacts)", f"{expected.position:.1e} m ({expected.point} at"):
        assert text in line
    assert "\ncheck " not in run("simulate", source, "--stop-time", "0.6")[1]


def test_a_rigid_impact_has_no_peak_force(run):
    """A rigid impact is an impulse without a peak force; a rigid wall exerts a force on a point at rest."""
    lines = impact_lines(run("simulate", "falling_arm", "--set", "outputs.loads=true")[1])
    assert [line[5:7] for line in lines[:3]] == [["—", "—"]] * 3
    assert [line[-2:] for line in lines[:3]] == [["—", "—"]] * 3
    lasting = [line for line in lines if line[6] != "—"]
    assert lasting[0][5:7] == ["lasts", "9.81"]
    assert float(lasting[0][-2]) > 0.0


def test_a_list_of_impacts_with_loads_fits_80_columns(run):
    lines = run("simulate", "falling_arm", "--set", "outputs.loads=true")[1].splitlines()
    table = lines[2 : lines.index(next(line for line in lines if line.startswith("…")))]
    assert len(table) > 30
    assert max(map(len, table)) <= 80


def test_simulate_runs_once_and_writes_nothing_unless_asked(run, work_folder, monkeypatch):
    calls, kernel_for_scene = [], instance.kernel_for

    def kernel_for(*arguments, **options):
        calls.append(arguments)
        return kernel_for_scene(*arguments, **options)

    monkeypatch.setattr(instance, "kernel_for", kernel_for)
    assert run("simulate", "rod_drop", "-q")[0] == 0
    assert list(work_folder.iterdir()) == []
    assert run("simulate", "rod_drop", "-q", "--csv", "out.csv")[0] == 0
    assert len(calls) == 2


@pytest.mark.full("takes long")
def test_csv_has_time_and_the_outputs_of_the_fmu_to_the_last_bit(run, work_folder, fmu):
    code, output, _ = run("simulate", fmu, "--csv", "out.csv")
    assert code == 0
    assert output.startswith("results  out.csv\n")
    names, rows = read_csv(work_folder / "out.csv")
    variables = PreparedScene(load_scene("four_link_box")).variables
    assert names == ["time", *(v.name for v in variables if v.causality == "output")]
    recording = record_fmu(fmu, {})
    columns = [recording.time, *recording.columns.values()]
    assert rows == [list(row) for row in zip(*(column.tolist() for column in columns), strict=True)]


def test_output_chooses_the_columns_of_the_table(run, work_folder):
    code, *_ = run("simulate", "rod_drop", "--csv", "out.csv", "--output", "point[*].x,energy.total")
    assert code == 0
    names, rows = read_csv(work_folder / "out.csv")
    result = simulate(load_scene("rod_drop"))
    assert names == ["time", "point[0].x", "point[1].x", "energy.total"]
    assert [row[3] for row in rows] == result["energy.total"].tolist()


@pytest.mark.parametrize(
    "suffix", [".csv", ".json", pytest.param(".parquet", marks=pytest.mark.full("needs pyarrow"))]
)
def test_the_list_of_impacts_is_written(run, work_folder, suffix):
    file = work_folder / f"list{suffix}"
    code, output, _ = run("simulate", "rod_drop", "--impacts", file)
    assert (code, output.splitlines()[0]) == (0, f"impacts  {file}")
    impacts = simulate(load_scene("rod_drop")).impacts
    if suffix == ".csv":
        with file.open(newline="", encoding="utf-8") as lines:
            rows = list(csv.DictReader(lines))
        assert {row["joint_force"] for row in rows} == {""}  # an unknown value is an empty cell
    else:
        read = json.loads(file.read_text("utf-8")) if suffix == ".json" else None
        rows = read or import_module("pyarrow.parquet").read_table(file).to_pylist()
        assert {row["joint_force"] for row in rows} == {None}
    assert [*rows[0]] == [name for name in impacts.dtype.names if name != "wall_name"]
    assert {row["wall"] for row in rows} == {"y_min"}
    for name in ("point", "onset", "peak_force", "impulse"):
        assert [float(row[name]) for row in rows] == impacts[name].tolist()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--impacts", "list.txt"), "argument --impacts: list.txt must end in .csv, .json, .parquet"),
        (
            ("--output", "point[1].x"),
            "--columns (--output): they are columns of a table: give --csv",
        ),
        (("--csv", "a.csv", "--output", "pt[1].x"), "pt[1].x is not a column; the nearest is point[1].x"),
        (("--csv", "a.csv", "--output", "solver.stepz"), "the nearest is solver.steps"),
    ],
)
def test_a_list_or_columns_that_cannot_be_written_are_refused(run, work_folder, options, expected):
    code, _, errors = run("simulate", "rod_drop", *options)
    assert code == 2
    assert expected in errors
    assert list(work_folder.iterdir()) == []


@pytest.mark.full("takes long")
@pytest.mark.parametrize("name", ["out.pdf", "OUT.PNG"])
def test_plot_writes_a_picture(run, work_folder, name):
    code, output, _ = run("simulate", "rod_drop", "--stop-time", "0.5", "--plot", name)
    assert (code, output.splitlines()[0]) == (0, f"picture  {name}")
    assert [path.name for path in work_folder.iterdir()] == [name]
    assert (work_folder / name).stat().st_size > 10_000


@pytest.mark.full("more cases", but="scene")
def test_set_changes_parameters(run, source):
    number = CONTACT_LAWS["flores"].number
    first = run("simulate", source, "--set", "contact.model=flores", "--set", "contact.restitution=0.5")
    second = run("simulate", source, "--set", f"contact.model={number}", "--set", "contact.restitution = 0.5")
    assert first[0] == 0
    assert first == second
    assert impact_lines(first[1]) != impact_lines(run("simulate", source)[1])


@pytest.mark.full("takes long")
def test_a_simulation_that_stops_early_gives_what_it_has(run, work_folder, source):
    files = ("--csv", "part.csv", "--plot", "part.png")
    code, output, errors = run("simulate", source, "--set", LITTLE_WORK, *files)
    assert code == 3
    assert re.fullmatch(r"chain-impact: .*stopped at t = [\d.]+ s: .*work_limit allows: .*\n", errors)
    assert output.startswith("results  part.csv\npicture  part.png\n")
    _, rows = read_csv(work_folder / "part.csv")
    assert 0.0 < rows[-1][0] < 2.0
    assert f"0 … {rows[-1][0]:g} s" in output
    assert (work_folder / "part.png").read_bytes().startswith(PNG)


def test_show_opens_one_window_with_the_picture(run, monkeypatch):
    titles, page = [], mpl.figure.Figure()
    page.canvas.required_interactive_framework = "a toolkit"
    monkeypatch.setattr(pyplot, "switch_backend", lambda _: None)
    monkeypatch.setattr(pyplot, "figure", lambda **_: page)
    monkeypatch.setattr(pyplot, "show", lambda: titles.append(page.get_suptitle()))
    assert run("simulate", "rod_drop", "--show")[0] == 0
    assert re.fullmatch(r"RodDrop: the peak force is \S+ kN", *titles)


def test_a_picture_and_a_window_have_rows_of_their_own(run, work_folder, fmu, monkeypatch):
    """At 10 rows per second a scene is drawn from 1001 rows; the picture of an FMU has poses only."""
    recordings, few_rows = [], ("--set", "simulation.step_size=0.1")
    code, _, output = run("simulate", fmu, *few_rows, "--plot", "a.png")
    assert code == 0
    assert "poses only, one each communication step, and cannot show the motion between them" in output
    monkeypatch.setattr(
        "chain_impact.pictures.picture.draw_overview",
        lambda _, recording, **_more: recordings.append(recording),
    )
    assert run("simulate", "four_link_box", *few_rows, "--plot", "a.png", "--csv", "a.csv")[0] == 0
    assert len((work_folder / "a.csv").read_text(encoding="utf-8").splitlines()) == 22
    monkeypatch.setattr("chain_impact.cli.simulate.open_window", mpl.figure.Figure)
    monkeypatch.setattr(pyplot, "show", lambda: None)
    assert run("simulate", "four_link_box", *few_rows, "--show")[0] == 0
    assert [len(recording.time) for recording in recordings] == [1001, 1001]


# --- compare ---------------------------------------------------------------------------------------------


def test_compare_prints_each_law_and_writes_the_files(run, work_folder):
    code, output, errors = run(
        "compare", "--set", "contact.restitution=0.5", "--set", "simulation.stop_time=0.6",
        "--csv", "laws.csv", "--plot", "laws.png",
    )  # fmt: skip
    assert (code, errors) == (0, "")
    table, *lines, picture = output.splitlines()
    assert [table, picture] == ["table    laws.csv", "picture  laws.png"]
    assert lines[1].startswith("FourLinkBox  e = 0.5, n = 1.5, K = 1e+08; first impact at 0.499446 s with ")
    assert [line.split()[0] for line in lines[3:] if line.split()[0] in CONTACT_LAWS] == list(CONTACT_LAWS)
    advised = "advice   within 5 % of e = 0.5 in this impact: "
    assert any(line.startswith(advised) and "zhang_sharf" in line for line in lines)
    assert (work_folder / "laws.png").read_bytes().startswith(PNG)
    with (work_folder / "laws.csv").open(newline="", encoding="utf-8") as file:
        assert [row["law"] for row in csv.DictReader(file)] == list(CONTACT_LAWS)


# --- arguments, and what all commands share --------------------------------------------------------------


def test_every_command_has_help_and_the_program_a_version(run):
    grammar = cli.parser()
    verbs = next(action.choices for action in grammar._actions if isinstance(action.choices, dict))
    assert run("--help")[1].startswith("usage: chain-impact ")
    for verb in verbs:
        code, output, _ = run(verb, "--help")
        assert code == 0
        assert output.startswith(f"usage: chain-impact {verb}")
        example = " ".join(output.split("example: chain-impact ")[1].split())
        assert grammar.parse_args(shlex.split(example)).run is verbs[verb].get_default("run")
    assert run("--version") == (0, f"chain-impact {version('chain-impact')}\n", "")


@pytest.mark.full("takes long")
def test_quiet_prints_nothing(run, work_folder):
    for verb, table in (("build", ""), ("simulate", "a.csv"), ("compare", "b.csv")):
        options = ("--csv", table) if table else ()
        assert run(verb, "rod_drop", "--quiet", *options) == (0, "", "")
    assert {path.name for path in work_folder.iterdir()} == {"build", "a.csv", "b.csv"}
    assert run("info", "rod_drop", "-q") == run("info", "rod_drop") != (0, "", "")  # the command only prints


def test_the_stop_time_can_be_given(run, source):
    result = run("simulate", source, "--stop-time", "0.52")
    assert result == run("simulate", source, "--set", "simulation.stop_time=0.52")
    assert "FourLinkBox  0 … 0.52 s, 1 impact\n" in result[1]


def test_an_interrupt_is_no_traceback(run, monkeypatch):
    def record(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("chain_impact.cli.source.Source.record", record)
    assert run("simulate") == (130, "", "chain-impact: interrupted\n")


def test_the_module_can_be_run(work_folder):
    process = program("simulate", "--set", "a=1")
    assert process.returncode == 2
    assert re.fullmatch(r"chain-impact: FourLinkBox: --set a=1 is not a parameter.*\n", process.stderr)


@pytest.mark.full("more cases", but="scene")
def test_set_takes_the_keys_of_a_scene_file(run, source):
    first = run("simulate", source, "--stop-time", "0.5", "--set", "chain.links[1].mass=1.5")
    assert first == run("simulate", source, "--stop-time", "0.5", "--set", "link[1].mass=1.5")
    code, _, errors = run("simulate", source, "--set", "chain.links[1].mass=heavy")
    assert code == 2
    assert ": --set chain.links[1].mass=heavy must be " in errors


@pytest.mark.full("takes long")
def test_a_picture_in_a_dark_style_is_dark_and_no_other_picture_is(run, work_folder):
    options = ("simulate", "pinned_arm", "--stop-time", "0.1", "--size", "84", "--plot")
    assert run(*options, "dark.png", "--style", "dark_background")[0] == run(*options, "light.png")[0] == 0
    corners = [pyplot.imread(work_folder / f"{name}.png")[0, 0, :3].tolist() for name in ("dark", "light")]
    assert corners == [[0.0] * 3, [1.0] * 3]
