"""The kernels of a wheel. (.ci/check_installation.py tests a real wheel.)"""

import ast
import lzma
import os
import re
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import prebuilt_kernels
import pytest

from chain_impact.compilation import browser, compilers, prebuilt
from chain_impact.compilation.library import kernel_library
from chain_impact.compilation.sources import COMPILERS, fingerprint
from chain_impact.system import HOST, PLATFORMS
from tests.tiers import needs_compilers

ROOT = Path(__file__).parents[2]
PLAIN = compilers.AnyLinks.PLAIN


def lower(module, part):
    module.write_text(part)


def compile_part(text, compiled, platform, part, scope):
    assert text == part
    compiled.write_text(f"{text} for {scope}")


def link(parts, library, platform):
    library.write_text(" and ".join(part.read_text() for part in parts))


def compile_for_browsers(text, compiled):
    compiled.write_text(f"{text} for a browser")


def link_for_browsers(compiled, module):
    module.write_text(compiled.read_text())


def replace_compilers(monkeypatch):
    """Replace the compilers by stand-ins that only write files."""
    stand_ins = {"prepare_zig": lambda _: None, "lower": lower, "compile_part": compile_part, "link": link}
    for name, function in stand_ins.items():
        monkeypatch.setattr(compilers, name, function)
    monkeypatch.setattr(browser, "compile_kernel", compile_for_browsers)
    monkeypatch.setattr(browser, "link", link_for_browsers)


@pytest.fixture
def messages():
    return []


@pytest.fixture
def prebuilt_folder(tmp_path, monkeypatch, messages):
    """Return a folder of prebuilt libraries, as in a wheel."""
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    replace_compilers(monkeypatch)
    assert not prebuilt_kernels.all_cached()
    prebuilt_kernels.make(tmp_path / "prebuilt", say=messages.append)
    monkeypatch.setattr(prebuilt, "FOLDER", tmp_path / "prebuilt")
    prebuilt._is_usable.cache_clear()
    yield tmp_path / "prebuilt"
    prebuilt._is_usable.cache_clear()


@needs_compilers
def test_a_second_wheel_of_the_same_sources_takes_no_compiler(prebuilt_folder, tmp_path, monkeypatch):
    monkeypatch.setattr(compilers, "lower", None)
    monkeypatch.setattr(compilers, "link", None)
    assert prebuilt_kernels.all_cached()
    prebuilt_kernels.make(tmp_path / "again")
    first, second = (
        sorted(path.name for path in folder.iterdir()) for folder in (prebuilt_folder, tmp_path / "again")
    )
    assert first == second


@needs_compilers
def test_there_is_a_kernel_for_every_chain_which_takes_no_compiler(prebuilt_folder, monkeypatch):
    monkeypatch.setattr(prebuilt, "find_spec", lambda _: None)
    library = prebuilt.find(prebuilt.library_name(PLAIN, "linux64", library_kind=prebuilt.DERIVATIVES))
    assert library.read_text() == "kernel for AnyLinks.PLAIN and derivatives for AnyLinks.PLAIN"
    assert kernel_library(4, derivatives=True) == library
    assert (
        prebuilt.find(prebuilt.library_name(prebuilt.exact_scope(64), "linux64")).read_text()
        == "kernel for AnyLinks.PLAIN"
    )
    assert prebuilt.find(prebuilt.library_name(3, "linux64")) is None
    assert kernel_library(4) == kernel_library(64) == prebuilt.find(prebuilt.library_name(PLAIN, "linux64"))
    assert prebuilt.find(prebuilt.library_name(PLAIN, "win64")) is None
    assert prebuilt.find(browser.MODULE).read_text() == "kernel for a browser"
    # four libraries, with and without derivatives and rare features, and a module for browsers
    assert len(prebuilt.prebuilt_kernels()) == 5
    assert prebuilt.lowered_kernel() == "kernel"
    assert lzma.decompress((prebuilt_folder / prebuilt.MODULE).read_bytes()) == b"kernel"
    assert not [path for path in prebuilt_folder.iterdir() if path.is_dir()]


@needs_compilers
def test_the_making_of_kernels_says_what_it_does(prebuilt_folder, messages):
    """pip shows these lines."""
    assert sorted(messages[:2]) == [
        f"compiling {part}, for any number of links" for part in sorted(prebuilt.LIBRARY_PARTS)
    ]
    assert "linking derivatives-any-linux64.so, 3 of 5" in messages
    assert len(messages) == 7


@needs_compilers
def test_a_long_step_says_that_work_goes_on(tmp_path, monkeypatch):
    messages = []
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(prebuilt_kernels, "PATIENCE", 0.01)
    replace_compilers(monkeypatch)

    def slow(module, part):
        while "still at work" not in messages:
            time.sleep(0.01)
        lower(module, part)

    monkeypatch.setattr(compilers, "lower", slow)
    prebuilt_kernels.make(tmp_path / "prebuilt", say=messages.append)
    assert "still at work" in messages


@needs_compilers
def test_a_wheel_for_release_carries_kernels_for_single_numbers_of_links(
    prebuilt_folder, tmp_path, monkeypatch
):
    """Kernels in the cache are not compiled again."""
    messages = []
    assert not prebuilt_kernels.all_cached(release=True)
    prebuilt_kernels.make(tmp_path / "release", release=True, say=messages.append)
    assert prebuilt_kernels.all_cached(release=True)
    assert not [line for line in messages if "kernel-any-" in line]
    monkeypatch.setattr(prebuilt, "FOLDER", tmp_path / "release")
    prebuilt._is_usable.cache_clear()
    # two with derivatives, and a browser module
    assert len(prebuilt.prebuilt_kernels()) == len(prebuilt.WHEEL_SCOPES) + 3
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "nothing"))
    for links in range(1, prebuilt.LARGEST_EXACT + 1):
        assert kernel_library(links).read_text() == f"kernel for {links}"
    for links in (4, 64):
        text = kernel_library(links, derivatives=True).read_text()
        assert text == "kernel for AnyLinks.PLAIN and derivatives for AnyLinks.PLAIN"


@needs_compilers
def test_kernels_of_other_sources_are_not_used(prebuilt_folder):
    """A user may have changed the kernel's sources in the installed package."""
    (prebuilt_folder / prebuilt.MADE_FROM).write_text("of before")
    prebuilt._is_usable.cache_clear()
    assert prebuilt.find(prebuilt.library_name(PLAIN, "linux64")) is None
    assert prebuilt.lowered_kernel() is None
    assert prebuilt.prebuilt_kernels() == []
    (prebuilt_folder / prebuilt.MADE_FROM).write_text(fingerprint())
    prebuilt._is_usable.cache_clear()
    assert len(prebuilt.prebuilt_kernels()) > 1


def test_compilers_and_python_of_a_wheel_are_those_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    process = backend("import backend; print('.'.join(map(str, backend.OLDEST)))")
    assert f">={process.stdout.strip()}" == project["requires-python"]
    compilers = project["optional-dependencies"]["compiler"]
    assert sorted(compilers) == sorted(f"{name}=={version}" for name, version in COMPILERS.items())
    assert [*compilers, "numpy>=2.0,<3"] == prebuilt_kernels.REQUIREMENTS


def backend(program, **settings):
    """Return the process of a program with the build backend; as under pip, nothing else is installed."""
    begin = (
        "import sys; sys.path.insert(0, 'packaging');"
        "sys.modules.update(dict.fromkeys(['numpy', 'numba', 'llvmlite', 'ziglang']));"
    )
    command, environment = [sys.executable, "-c", begin + program], {**os.environ, **settings}
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


@needs_compilers
def test_the_build_backend_asks_for_compilers_only_where_they_are_needed(tmp_path):
    program = "import backend; print(backend.get_requires_for_build_{}())"
    wheel, editable = (
        ast.literal_eval(backend(program.format(kind), CHAIN_IMPACT_CACHE=str(tmp_path)).stdout)
        for kind in ("wheel", "editable")
    )
    assert set(prebuilt_kernels.REQUIREMENTS) <= set(wheel)
    assert not set(prebuilt_kernels.REQUIREMENTS) & set(editable)


@needs_compilers
def test_a_release_wheel_needs_compilers_if_only_first_kernels_are_cached(prebuilt_folder, tmp_path):
    program = "import backend; print(backend.get_requires_for_build_wheel())"
    for release in "01":
        # the fixture has cached the first kernels only
        process = backend(program, CHAIN_IMPACT_RELEASE=release)
        requirements = set(ast.literal_eval(process.stdout))
        assert bool(set(prebuilt_kernels.REQUIREMENTS) & requirements) == (release == "1")


def test_a_wheel_is_for_this_machine_unless_another_platform_is_named():
    program = "import kernel_hook; print(kernel_hook.target())"
    assert backend(program, CHAIN_IMPACT_PLATFORM="").stdout.strip() == HOST
    assert backend(program, CHAIN_IMPACT_PLATFORM="win64").stdout.strip() == "win64"
    refused = backend(program, CHAIN_IMPACT_PLATFORM="amiga").stderr.splitlines()[-1]
    assert refused.startswith("RuntimeError: CHAIN_IMPACT_PLATFORM = amiga must be one of linux64, win64")
    elsewhere = "from chain_impact import system; system.HOST = '';"
    process = backend(f"import kernel_hook; kernel_hook.kernels(); {elsewhere} kernel_hook.target()")
    assert process.stderr.splitlines()[-1].startswith("RuntimeError: chain-impact runs on Linux ")


def test_the_tag_of_a_wheel_is_that_of_its_platform():
    process = backend("import kernel_hook; print(*map(kernel_hook.tag, kernel_hook.platforms()))")
    assert process.stdout.split() == [f"py3-none-{platform.tag}" for platform in PLATFORMS.values()]


def test_an_older_python_is_refused_in_one_sentence():
    process = backend("sys.version_info = (3, 10, 13); import backend")
    assert process.returncode == 1
    assert re.fullmatch(
        r"chain-impact needs Python 3\.11 or later, and this is \S+ \(\S+\)\n", process.stderr
    )
