"""The page: it stands alone, holds what the recording holds, and its parts are what npm has."""

import base64
import hashlib
import json
import re
import shutil
import subprocess
import tarfile

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.results.animation.frames import motion_of
from chain_impact.results.animation.page import FRAGMENTS, MODULES, PAGE, data, page, program
from chain_impact.results.result import recording_of
from chain_impact.studies.slow_motion import record_slowly

# file → package of npm, version, path in the package
VENDORED = {
    "uPlot.iife.min.js": ("uplot", "1.6.32", "dist/uPlot.iife.min.js"),
    "uPlot.min.css": ("uplot", "1.6.32", "dist/uPlot.min.css"),
    "uPlot.LICENSE": ("uplot", "1.6.32", "LICENSE"),
    "svg.min.js": ("@svgdotjs/svg.js", "3.2.8", "dist/svg.min.js"),
    "svg.LICENSE": ("@svgdotjs/svg.js", "3.2.8", "LICENSE.txt"),
}
DIGESTS = {
    "uPlot.iife.min.js": "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
    "uPlot.min.css": "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
    "uPlot.LICENSE": "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
    "svg.min.js": "90fc33bcba8181aa5e96e5c975da19f0912d7097a4ec9056ba130fc3ce328ec6",
    "svg.LICENSE": "455113977c98c54dad8598e092b99aad6be0ed8c5c4a0722154acf4b21df4730",
}


@pytest.fixture(scope="module")
def motion():
    return motion_of(record_slowly(load_scene("four_link_box")))


def unpacked(packed):
    values = np.frombuffer(base64.b64decode(packed["values"]), "<u2")
    return packed["low"] + (packed["high"] - packed["low"]) * values / 65535


def test_the_page_needs_nothing_else(motion):
    text = re.sub(r"<script>.*?</script>", "", page(motion), flags=re.DOTALL)  # without the libraries
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", text)
    assert not re.findall(r"@import|url\((?!data:)", text)
    assert "{{" not in text


def test_what_is_packed_is_the_motion(motion):
    packed = json.loads(json.dumps(data(motion, 0.5)))
    time = np.frombuffer(base64.b64decode(packed["time"]), "<f8")
    np.testing.assert_array_equal(time, motion.time)
    for axis in (0, 1):
        points = unpacked(packed["points"][axis]).reshape(len(time), -1)
        np.testing.assert_allclose(points, motion.points[:, :, axis], atol=5e-5)
    np.testing.assert_allclose(unpacked(packed["energies"]["total"]), motion.energies["total"], atol=1e-3)
    for force in packed["forces"]:
        whole = np.zeros(len(time))
        whole[np.frombuffer(base64.b64decode(force["frames"]), "<u4")] = unpacked(force)
        np.testing.assert_allclose(whole, motion.forces[force["point"], force["wall"]], atol=0.5)


def test_ten_seconds_of_four_links_are_small():
    scene = load_scene("four_link_box").with_values({"simulation.stop_time": 10.0})
    assert len(page(motion_of(record_slowly(scene)))) < 1_500_000


def test_a_recording_with_even_rows_has_a_page_too():
    page(motion_of(recording_of(simulate(load_scene("pinned_arm")))))


def test_a_name_cannot_break_the_page(motion):
    name = "</script><b>&{{ data }}"
    text = page(type(motion)(**{**vars(motion), "name": name}))
    assert "&lt;/script&gt;&lt;b&gt;&amp;" in text
    embedded = re.search(r'<script id="data"[^>]*>(.*?)</script>', text, re.DOTALL)[1]
    assert json.loads(embedded)["name"] == name


def test_the_modules_are_one_program():
    text = program()
    assert not re.search(r"^(import|export)\b", text, re.MULTILINE)
    names = re.findall(r"^(?:const|let|function|class) (\w+)", text, re.MULTILINE)
    assert len(names) == len(set(names)), "two modules have a name in common, but are put into one"


def test_a_module_imports_what_stands_before_it():
    for place, name in enumerate(MODULES):
        text = PAGE.joinpath(f"{name}.js").read_text(encoding="utf-8")
        used = re.findall(r'^import .* from "\./(\w+)\.js";$', text, re.MULTILINE)
        assert set(used) <= set(MODULES[:place])
        assert len(text.splitlines()) < 400


def test_the_folder_holds_what_the_page_is_made_of():
    files = {file.name for file in PAGE.iterdir() if file.is_file()}
    pages = {f"{name}.html" for name in ("index", *FRAGMENTS)}
    assert files == {*pages, "style.css", "panels.css", *(f"{name}.js" for name in MODULES)}
    assert {file.name for file in (PAGE / "vendor").iterdir()} == {*VENDORED, "README.md"}


@pytest.mark.parametrize("name", VENDORED)
def test_the_libraries_are_those_of_npm(name):
    content = (PAGE / "vendor" / name).read_bytes()
    assert hashlib.sha256(content).hexdigest() == DIGESTS[name]
    _, version, _ = VENDORED[name]
    assert version in (PAGE / "vendor" / "README.md").read_text(encoding="utf-8")


@pytest.mark.full("takes long")
@pytest.mark.skipif(shutil.which("npm") is None, reason="needs npm")
@pytest.mark.parametrize(("package", "version"), sorted({entry[:2] for entry in VENDORED.values()}))
def test_npm_has_the_same_files(tmp_path, package, version):
    packed = subprocess.run(
        ["npm", "pack", "--silent", f"{package}@{version}"], cwd=tmp_path, check=False, capture_output=True
    )
    if packed.returncode != 0:
        pytest.skip("npm's registry cannot be reached")
    (archive,) = tmp_path.glob("*.tgz")
    with tarfile.open(archive) as files:
        for name, (owner, _, path) in VENDORED.items():
            if owner == package:
                content = files.extractfile(f"package/{path}").read()
                assert content == (PAGE / "vendor" / name).read_bytes()
