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
from tests.fmu.planted_faults import spoiled

every_model = pytest.mark.parametrize("model", model_names())
FILES = {"manifest": MANIFEST}
FILES |= {"out": f"{FOLDER}/FourLinkBox_out.csv", "experiments": f"{FOLDER}/FourLinkBox.exp"}


def said(path):
    """What the check says of an FMU with one experiment: whether it passed, and the line."""
    (outcome,) = check_references(Path(path))
    return outcome.passed, outcome.text


@pytest.fixture
def spoil(native, tmp_path):
    """Change files of the FMU of four_link_box: name → function of the text, or None to leave it out."""

    def change(name, content, changes):
        key = next((key for key in changes if FILES[key] == name), None)
        if key is None:
            return content
        return changes[key](content.decode()).encode() if changes[key] else None

    return lambda **changes: spoiled(
        native["four_link_box"], tmp_path / "x.fmu", lambda *file: change(*file, changes)
    )


# --- what is written -------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=8)
@every_model
def test_every_model_keeps_to_its_reference_which_is_small_and_where_the_draft_has_it(fmus, model):
    passed, text = said(fmus[model])
    assert passed, text
    assert re.match(r"experiment default: passed, outputs: 1\d, times: \d+, until ", text)
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


def test_the_times_are_those_that_can_be_relied_on():
    """None is close to the begin or end of a contact; of 1000 s that amplify every error some 2 are left."""
    scene = load_scene("four_link_box")
    usual, long, fine, coarse = (
        reference(Model(scene.with_values(changes)))
        for changes in (
            {},
            {"simulation.stop_time": 1000.0},
            {"solver.tolerance": 1e-10},
            {"solver.tolerance": 1e-4},
        )
    )
    impacts = simulate(scene).impacts
    edges = np.concatenate([impacts["onset"], impacts["end"]])
    assert np.nanmin(np.abs(usual.times[:, None] - edges)) > 1e-6
    assert 1.0 < long.times[-1] < 10.0
    assert ROWS / 10 < len(long.times) <= ROWS + 1
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
    with zipfile.ZipFile(native["four_link_box"]) as right:
        path = spoiled(
            build_fmu(soft, tmp_path, target="native"),
            tmp_path / "x.fmu",
            lambda name, content: right.read(name) if name.startswith(FOLDER) else content,
        )
    passed, text = said(path)
    assert not passed
    first = simulate(soft).impacts["onset"][0]
    assert first < float(re.search(r"at t = (\S+) s", text)[1]) < first + 0.1


def test_inputs_that_do_not_arrive_are_found(native, tmp_path):
    def change(name, content):
        return re.sub(rb"<Stimuli [^>]*/>", b"", content) if name.endswith(".exp") else content

    passed, text = said(spoiled(native["controlled_arm"], tmp_path / "x.fmu", change))
    assert not passed
    assert "outputs deviate" in text


def with_other(old, new):
    return lambda text: re.sub(old, new, text, flags=re.DOTALL)


@pytest.mark.parametrize(
    ("file", "change", "sentence"),
    [
        ("out", None, "FourLinkBox_out.csv is not in the FMU"),
        ("experiments", None, "FourLinkBox.exp is not in the FMU"),
        ("experiments", lambda text: text[:200], "FourLinkBox.exp is no XML"),
        ("manifest", lambda text: text[:200], "fmi-ls-manifest.xml is no XML"),
        ("out", with_other(r"point\[4\]\.x", "point[9].x"), "the FMU has no variable point[9].x"),
        ("out", with_other("time,", "t,"), "must be a table with a column time"),
        ("out", lambda text: f"{text}1,2\n", "rows of equal length"),
        ("out", lambda text: "", "must be a table"),
        ("out", with_other("\n0.02,", "\nsoon,"), "increasing numbers"),
        ("experiments", with_other('stopTime="', 'stopTime="x'), "must be a finite number"),
        ("experiments", with_other('stepSize="0.02"', 'stepSize="-1"'), "cannot be simulated"),
    ],
)
def test_what_is_wrong_is_said(spoil, file, change, sentence):
    first = check_references(spoil(**{file: change}))[0]
    assert not first.passed
    assert sentence in first.text


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("<References", '<Parameters source="a.ssv"/><References', "sets of parameters"),
        ("<References", '<References type="application/hdf5"', "hdf5 is not supported"),
        ("<References.*</References>", "", "no reference results"),
    ],
)
def test_what_is_not_supported_is_no_fault(spoil, old, new, sentence):
    outcome = check_references(spoil(experiments=with_other(old, new)))[0]
    assert outcome.passed
    assert "not run: " in outcome.text
    assert sentence in outcome.text


@pytest.mark.full("takes long")
def test_an_fmu_for_another_platform_is_not_run(tmp_path):
    passed, text = said(build_fmu("rod_drop", tmp_path, target="native", platforms=["win64"]))
    assert passed
    assert "no binary for linux64" in text


def test_what_others_write_is_read(spoil):
    """No experiment, nor how exact results are; times in an element of their own; columns of text."""
    passed, text = said(spoil(manifest=with_other(r"<Related [^>]*\.exp[^>]*/>", "")))
    assert passed, text
    assert text.startswith("results FourLinkBox_out.csv: passed")
    assert text.endswith("within 0.1% of the range where no tolerance is stated")

    def moved(text):
        pattern = r' (?:startTime|stopTime|stepSize)="[^"]*"'
        element = f"<TransientSimulation{''.join(re.findall(pattern, text))}/><References"
        return re.sub(pattern, "", text).replace("<References", element)

    def with_text(table):
        head, *rows = table.splitlines()
        return "\n".join([f"{head},description", *(f"{row},text" for row in rows)])

    for passed, text in (said(spoil(experiments=moved)), said(spoil(out=with_text))):
        assert passed, text
