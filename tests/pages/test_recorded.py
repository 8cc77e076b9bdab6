"""The pages: small, without other files, made from their sources, with the parts of npm's packages."""

# Tests: pages/assembly.py, pages/encoding.py, pages/inline.py
# Tests: pages/browser/base/base64.js, pages/browser/player/packed_recording.js

import base64
import hashlib
import json
import re

import numpy as np
import pytest
import quickjs

from chain_impact import Recording, load_scene, model_names, simulate
from chain_impact.pages import explore, recorded
from chain_impact.pages.assembly import FRAGMENTS, PAGE, STYLES, browser_text, module_files, program_text
from chain_impact.pages.recorded import data_of_page, recorded_page
from chain_impact.studies.animate import record_slowly
from tests.helpers.scenes.friction import pendulum, sled
from tests.helpers.scenes.stops import knee_scene
from tests.helpers.tools.page_data import data_of

# file → version of its package in npm
VENDORED = {"uPlot.iife.min.js": "1.6.32", "uPlot.min.css": "1.6.32", "uPlot.LICENSE": "1.6.32"}
VENDORED |= {"svg.min.js": "3.2.8", "svg.LICENSE": "3.2.8"}
VENDORED |= {"smol-toml.cjs": "1.9.1", "smol-toml.LICENSE": "1.9.1"}
DIGESTS = {
    "uPlot.iife.min.js": "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
    "uPlot.min.css": "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
    "uPlot.LICENSE": "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
    "svg.min.js": "90fc33bcba8181aa5e96e5c975da19f0912d7097a4ec9056ba130fc3ce328ec6",
    "svg.LICENSE": "455113977c98c54dad8598e092b99aad6be0ed8c5c4a0722154acf4b21df4730",
    "smol-toml.cjs": "f9029370259e9a43a2f3e64fa1d39e72f3598188380ace83a0abb8261fa33555",
    "smol-toml.LICENSE": "fa5659948374d4f555594f47f6da073b40dc503e921aeeece30df4362b3051a5",
}

PROGRAMS = (recorded.RECORDED_PROGRAM, explore.BEGIN, explore.PROGRAM, explore.WORKER)


@pytest.fixture(scope="module")
def recording():
    return record_slowly(load_scene("four_link_box"))


def html(recording):
    return recorded_page(recording, 1.0, 0.6)


def unpacked(packed):
    values = np.frombuffer(base64.b64decode(packed["values"]), "<u2")
    return packed["low"] + (packed["high"] - packed["low"]) * values / 65535


def whole(entry, name, time):
    """Return the values of a quantity of an entry in all rows."""
    values = np.zeros(len(time))
    values[np.frombuffer(base64.b64decode(entry["rows"]), "<u4")] = unpacked(entry["columns"][name])
    return values


def test_the_page_needs_nothing_else(recording):
    assert_alone(html(recording))


def assert_alone(text):
    """Assert that a page loads no other file."""
    text_without_scripts = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)  # without the libraries
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", text_without_scripts)
    assert not re.findall(r"@import|url\((?!data:|#)|\bfetch\(|XMLHttpRequest", text_without_scripts)
    assert "{{" not in text_without_scripts


def test_the_packed_data_are_the_recording(recording):
    packed = json.loads(json.dumps(data_of_page(recording)))
    time = np.frombuffer(base64.b64decode(packed["time"]), "<f8")
    np.testing.assert_array_equal(time, recording.time)
    for axis, name in enumerate("xy"):
        points = unpacked(packed[name]).reshape(len(time), -1)
        np.testing.assert_allclose(points, recording.points[:, :, axis], atol=5e-5)
    (energies,) = packed["drawn"]["energies"]
    np.testing.assert_allclose(whole(energies, "total", time), recording.energies["total"], atol=1e-3)
    forces = {
        (interaction.point, interaction.wall): interaction.force for interaction in recording.interactions
    }
    for contact in packed["drawn"]["contacts"]:
        expected = forces.pop((contact["n"], contact["name"]))
        np.testing.assert_allclose(whole(contact, "force", time), expected, atol=0.5)
    assert not any(force.any() for force in forces.values())
    assert [impact["onset"] for impact in packed["impacts"]] == recording.impacts["onset"].tolist()
    assert packed["touching"] == [[point, 0.0] for point in range(5)]
    assert packed["pinned"] is False


def test_friction_and_what_sticks():
    first, second = (entry["columns"] for entry in data_of_page(record_slowly(sled()))["drawn"]["contacts"])
    assert first["friction"]["low"] < -2.0
    assert first["sticking"] == second["sticking"]
    joints = data_of_page(record_slowly(pendulum()))["drawn"]["joints"]
    assert [(joint["n"], joint["name"]) for joint in joints] == [(1, ""), (2, "")]
    assert [set(unpacked(joint["columns"]["sticking"])) for joint in joints] == [{1.0}, {1.0}]


def test_forces_in_joints():
    recording = simulate(load_scene("pinned_arm").with_values({"outputs.loads": True}))
    loads = data_of_page(recording)["drawn"]["loads"]
    packed = {load["n"]: [whole(load, axis, recording.time) for axis in "xy"] for load in loads}
    assert packed.keys() == {1, 2}
    for joint, force in packed.items():
        expected = np.transpose([recording[f"joint[{joint}].force.{axis}"] for axis in "xy"])
        np.testing.assert_allclose(np.transpose(force), expected, atol=0.01)


def test_the_page_has_the_ranges_and_tells_stops_from_walls():
    packed = data_of_page(simulate(knee_scene()))
    assert packed["stops"] == [{"joint": 2, "arc": (0.0, 2.0), "marks": [0.0, 2.0]}]
    assert {impact["wall"]: impact["atStop"] for impact in packed["impacts"]} == {
        "joint_min": True,
        "x_max": False,
    }
    first = packed["impacts"][0]
    assert first["linearSpeed"] == 0.5 * first["impact_speed"]


def test_ten_seconds_of_four_links_are_small():
    scene = load_scene("four_link_box").with_values({"simulation.stop_time": 10.0})
    assert len(html(record_slowly(scene))) < 1_500_000


def test_thinned_rows_keep_shown_rows_and_rows_beside_impacts(monkeypatch):
    monkeypatch.setattr(recorded, "MOST_PAGE_ROWS", 1000)
    full_recording = simulate("four_link_box", output_step=1e-5)
    thin_recording = recorded.thin_rows(full_recording, 0.6)
    assert len(thin_recording.time) < 0.2 * len(full_recording.time)
    assert (thin_recording.time[[0, -1]] == full_recording.time[[0, -1]]).all()
    assert thin_recording.impacts.tobytes() == full_recording.impacts.tobytes()
    for moment in (*full_recording.impacts["onset"], *full_recording.impacts["end"]):
        row = int(np.searchsorted(full_recording.time, moment))
        assert np.isin(full_recording.time[row - 1 : row + 1], thin_recording.time).all()
    # rows stay where the motion and the forces between the rows are shown
    hit = "contact[2].y_min.force"
    assert np.diff(thin_recording.time).max() < 2.1 * np.ptp(full_recording.time) / 1000
    assert thin_recording.columns[hit].max() > 0.9 * full_recording[hit].max()
    rows = np.searchsorted(full_recording.time, thin_recording.time)
    np.testing.assert_array_equal(thin_recording.points, full_recording.points[rows])
    assert len(html(full_recording)) < 0.4 * len(html_of_all(full_recording, monkeypatch))


def html_of_all(recording, monkeypatch):
    monkeypatch.setattr(recorded, "MOST_PAGE_ROWS", len(recording.time))
    return html(recording)


def test_a_recording_with_even_rows_has_a_page_too():
    assert "PinnedArm" in html(simulate("pinned_arm"))


def test_a_name_cannot_break_the_page(recording):
    recording = Recording(name := "</script><b>&{{ data }}", recording.time, recording.columns)
    text = html(recording)
    assert "&lt;/script&gt;&lt;b&gt;&amp;" in text
    assert data_of(text)["name"] == name


@pytest.mark.full("more cases", but=6)
@pytest.mark.parametrize("model", model_names())
def test_the_page_of_every_model_is_small_and_needs_nothing_else(model):
    text = explore.explore_page(load_scene(model), [model])
    assert len(text.encode()) < 900_000
    assert_alone(text)


def test_a_law_has_a_sentence_with_its_range_and_source():
    groups = data_of(explore.explore_page(load_scene("rod_drop"), []))["kit"]["parameters"]
    rows = {row["name"]: row for group in groups for row in group["rows"]}
    sentences = dict(rows["contact.model"]["items"])
    assert (
        sentences["zhang_sharf"]
        == "Exact for one contact on its own, for all e > 0. Zhang & Sharf 2009, J Appl Mech 76:051002."
    )


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_modules_are_one_program(name):
    text = program_text(name)
    assert not re.search(r"^(import|export)\b", text, re.MULTILINE)
    quickjs.Context().get("Function")(f"async () => {{\n{text}\n}}")
    # the modules share one scope, in which a second function of a name would silently replace the first
    sources = "".join(map(browser_text, module_files(name)))  # whose lines at the top level are not indented
    declared = re.findall(
        r"^(?:export )?(?:async )?(?:function\*?|class|const|let|var) (\w+)", sources, re.MULTILINE
    )
    assert len(declared) > 10
    assert sorted(declared) == sorted(set(declared))


def test_the_folders_hold_what_the_pages_are_made_of():
    files = {file.relative_to(PAGE).as_posix() for file in PAGE.rglob("*") if file.is_file()}
    parts = {f"player/{name}.html" for name in ("recorded_page", *FRAGMENTS)}
    parts |= {"explore/explore.html", "explore/explore.css", *STYLES, *module_files(*PROGRAMS)}
    assert files == parts | {f"vendor/{name}" for name in ("README.md", *VENDORED)}


@pytest.mark.parametrize("name", VENDORED)
def test_the_libraries_are_those_of_npm(name):
    content = (PAGE / "vendor" / name).read_bytes()
    assert hashlib.sha256(content).hexdigest() == DIGESTS[name]
    assert VENDORED[name] in (PAGE / "vendor" / "README.md").read_text(encoding="utf-8")
