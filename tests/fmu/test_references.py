"""Reference results in FMUs: what they say holds, and what is wrong with spoiled ones is found."""

import io
import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.fmu.build import build_fmu
from chain_impact.fmu.check_references import check_references
from chain_impact.fmu.references import EXACT, FOLDER, MANIFEST, NAMESPACE, ROWS, reference
from chain_impact.results.result import recording_of
from chain_impact.scene.scene import model_names
from chain_impact.variables.model import Model

every_model = pytest.mark.parametrize("model", model_names())
OUT, EXPERIMENTS = f"{FOLDER}/FourLinkBox_out.csv", f"{FOLDER}/FourLinkBox.exp"


def said(path):
    """What the check says of an FMU with one experiment: whether it passed, and the line."""
    (outcome,) = check_references(Path(path))
    return outcome.passed, outcome.text


@pytest.fixture
def spoil(native, tmp_path):
    """Change files of the FMU of four_link_box: name → function of the text, or None to leave it out."""

    def spoiled(**changes):
        changes = {name: changes[key] for key, name in FILES.items() if key in changes}
        with zipfile.ZipFile(native["four_link_box"]) as old, zipfile.ZipFile(tmp_path / "x.fmu", "w") as new:
            for name in old.namelist():
                change = changes.get(name, lambda text: text)
                content = old.read(name)
                if name in changes:
                    content = change(content.decode()).encode() if change else None
                if content is not None:
                    new.writestr(name, content)
        return tmp_path / "x.fmu"

    return spoiled


FILES = {"manifest": MANIFEST, "experiments": EXPERIMENTS, "out": OUT}


# --- what is written -------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=8)
@every_model
def test_every_model_keeps_to_its_reference(fmus, model):
    passed, text = said(fmus[model])
    assert passed, text
    assert re.match(r"experiment default: passed, outputs: 1\d, times: \d+, until ", text)


@pytest.mark.full("more cases", but=24)
@every_model
def test_the_files_are_small_and_found_where_the_draft_has_them(fmus, model):
    with zipfile.ZipFile(fmus[model]) as fmu:
        sizes = {entry.filename: entry.compress_size for entry in fmu.infolist()}
        manifest = ElementTree.fromstring(fmu.read(MANIFEST))
    assert manifest.tag == "fmiReferences"
    assert manifest.get(f"{{{NAMESPACE}}}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    related = {(node.get("role"), f"{FOLDER}/{node.get('source')}") for node in manifest}
    assert {role for role, _ in related} == {"experiment/smoke-test", "result"}
    assert {name for _, name in related} <= sizes.keys()
    assert sum(size for name, size in sizes.items() if name.startswith(FOLDER)) < 12_000


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("model", ["four_link_box", "rod_drop", "ramp"])
def test_the_results_are_those_of_another_method_at_a_tight_tolerance(native, model):
    """The explicit method with the reference's tolerance, in steps of its own."""
    scene = load_scene(model)
    with zipfile.ZipFile(native[model]) as fmu:
        table = fmu.read(f"{FOLDER}/{scene.name}_out.csv").decode()
        tolerances = ElementTree.fromstring(fmu.read(f"{FOLDER}/{scene.name}.exp")).iter("Tolerance")
        tolerances = {node.get("name"): float(node.get("absolute")) for node in tolerances}
    names = table.partition("\n")[0].split(",")
    columns = dict(zip(names, np.loadtxt(io.StringIO(table), delimiter=",", skiprows=1).T, strict=True))
    exact = simulate(scene, tolerance=EXACT, method="explicit")
    recorded = recording_of(exact)
    compared = [name for name in names if name in recorded.columns]
    assert len(compared) > 8
    rows = np.searchsorted(exact.time, columns["time"] - 1e-9)
    for name in compared:
        # a tenth of what is tolerated is what the FMU's own tolerance may take
        error = np.abs(recorded.columns[name][rows] - columns[name]).max()
        assert error <= tolerances[name] / 5 + 1e-10, name
    begun = [np.sum(exact.impacts["onset"] <= time) for time in columns["time"]]
    assert columns["impact.count"].tolist() == begun


def test_no_row_is_close_to_the_begin_or_end_of_a_contact():
    scene = load_scene("four_link_box")
    found, impacts = reference(Model(scene)), simulate(scene).impacts
    edges = np.concatenate([impacts["onset"], impacts["end"]])
    assert np.nanmin(np.abs(found.times[:, None] - edges)) > 1e-6


def test_a_long_run_has_a_short_experiment():
    """Of 1000 s of a chain that amplifies every error, two can be relied on."""
    scene = load_scene("four_link_box").with_values({"simulation.stop_time": 1000.0})
    found = reference(Model(scene))
    assert 1.0 < found.times[-1] < 10.0
    assert ROWS / 10 < len(found.times) <= ROWS + 1


def test_a_coarse_tolerance_has_a_short_experiment():
    scene = load_scene("four_link_box")
    scenes = (scene.with_values({"solver.tolerance": tolerance}) for tolerance in (1e-10, 1e-4))
    fine, coarse = (reference(Model(one)) for one in scenes)
    assert coarse.times[-1] < fine.times[-1]


def test_inputs_differ_from_each_other_and_act(native):
    with zipfile.ZipFile(native["controlled_arm"]) as fmu:
        names, *rows = fmu.read(f"{FOLDER}/ControlledArm_in.csv").decode().split()
    assert names == "time,joint[1].torque,joint[2].torque"
    values = np.array([row.split(",") for row in rows], float)
    assert np.ptp(values[:, 1:], axis=0).min() > 0.01
    assert np.abs(values[:, 1] - values[:, 2]).max() > 0.01
    found = reference(Model(load_scene("controlled_arm")))
    supplied = found.values[:, [v.name for v in found.outputs].index("energy.supplied")]
    assert np.abs(supplied).max() > 0.01


def test_a_scene_that_cannot_run_has_no_reference_and_that_is_said(tmp_path, caplog):
    scene = load_scene("rod_drop").with_values({"solver.work_limit": 1.0})
    caplog.set_level("INFO", "chain_impact")
    path = build_fmu(scene, tmp_path, target="native")
    assert any(text.startswith("no reference results in the FMU: ") for text in caplog.messages)
    assert check_references(path) == []


# --- what is found ---------------------------------------------------------------------------------------


def test_a_result_that_was_changed_is_found(spoil):
    def change(table):
        rows = [line.split(",") for line in table.splitlines()]
        rows[50][rows[0].index("point[4].x")] = "1.5"
        return "\n".join(map(",".join, rows))

    passed, text = said(spoil(out=change))
    assert not passed
    assert re.search(r"point\[4\]\.x = \S+ in place of 1\.5 at t = 0\.98 s: \S+ off, \S+ allowed$", text)


def test_another_model_is_found(native, tmp_path):
    """The FMU of a softer wall with the results of the right one: the first row after the first impact."""
    soft = load_scene("four_link_box").with_values({"contact.stiffness": 0.99e8})
    with (
        zipfile.ZipFile(build_fmu(soft, tmp_path, target="native")) as other,
        zipfile.ZipFile(native["four_link_box"]) as right,
        zipfile.ZipFile(tmp_path / "x.fmu", "w") as new,
    ):
        for name in other.namelist():
            new.writestr(name, (right if name.startswith(FOLDER) else other).read(name))
    passed, text = said(tmp_path / "x.fmu")
    assert not passed
    time = float(re.search(r"at t = (\S+) s", text)[1])
    first = simulate(soft).impacts["onset"][0]
    assert first < time < first + 0.1


def test_inputs_that_do_not_arrive_are_found(native, tmp_path):
    with zipfile.ZipFile(native["controlled_arm"]) as old, zipfile.ZipFile(tmp_path / "x.fmu", "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name.endswith(".exp"):
                content = re.sub(rb"<Stimuli [^>]*/>", b"", content)
            new.writestr(name, content)
    passed, text = said(tmp_path / "x.fmu")
    assert not passed
    assert "outputs deviate" in text


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"out": None}, "FourLinkBox_out.csv is not in the FMU"),
        ({"experiments": None}, "FourLinkBox.exp is not in the FMU"),
        ({"experiments": lambda text: text[:200]}, "FourLinkBox.exp is no XML"),
        ({"manifest": lambda text: text[:200]}, "fmi-ls-manifest.xml is no XML"),
        (
            {"out": lambda text: text.replace("point[4].x", "point[9].x")},
            "the FMU has no variable point[9].x",
        ),
        ({"out": lambda text: text.replace("time,", "t,")}, "must be a table with a column time"),
        ({"out": lambda text: text + "1,2\n"}, "rows of equal length"),
        ({"out": lambda text: ""}, "must be a table"),
        ({"out": lambda text: text.replace("\n0.02,", "\nsoon,")}, "increasing numbers"),
        ({"experiments": lambda text: text.replace('stopTime="', 'stopTime="x')}, "must be a finite number"),
        (
            {"experiments": lambda text: text.replace('stepSize="0.02"', 'stepSize="-1"')},
            "cannot be simulated",
        ),
    ],
)
def test_what_is_wrong_is_said(spoil, changes, sentence):
    first = check_references(spoil(**changes))[0]
    assert not first.passed
    assert sentence in first.text


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            lambda text: text.replace("<References", '<Parameters source="a.ssv"/><References'),
            "sets of parameters",
        ),
        (
            lambda text: text.replace("<References", '<References type="application/hdf5"'),
            "hdf5 is not supported",
        ),
        (lambda text: re.sub("<References.*</References>", "", text, flags=re.S), "no reference results"),
    ],
)
def test_what_is_not_supported_is_no_fault(spoil, change, sentence):
    outcome = check_references(spoil(experiments=change))[0]
    assert outcome.passed
    assert "not run: " in outcome.text
    assert sentence in outcome.text


@pytest.mark.full("takes long")
def test_an_fmu_for_another_platform_is_not_run(tmp_path):
    path = build_fmu("rod_drop", tmp_path, target="native", platforms=["win64"])
    passed, text = said(path)
    assert passed
    assert "no binary for linux64" in text


def test_results_without_an_experiment_are_those_of_the_default_one(spoil):
    """As the Reference-FMUs have them; with rows that do not state how exact they are."""

    def without_experiment(manifest):
        return re.sub(r"<Related [^>]*\.exp[^>]*/>", "", manifest)

    path = spoil(manifest=without_experiment)
    passed, text = said(path)
    assert passed, text
    assert text.startswith("results FourLinkBox_out.csv: passed")
    assert text.endswith("within 0.1% of the range where no tolerance is stated")


def test_times_in_an_element_of_their_own_are_read(spoil):
    """As the schema of the experiments format has them since the summer of 2026."""

    def moved(text):
        times = " ".join(re.findall(r'(?:startTime|stopTime|stepSize)="[^"]*"', text))
        text = re.sub(r' (?:startTime|stopTime|stepSize)="[^"]*"', "", text)
        return text.replace("<References", f"<TransientSimulation {times}/><References")

    passed, text = said(spoil(experiments=moved))
    assert passed, text


def test_text_and_empty_columns_are_left_out(spoil):
    def change(table):
        head, *rows = table.splitlines()
        return "\n".join([f"{head},description", *(f"{row},text" for row in rows)])

    assert said(spoil(out=change))[0]
