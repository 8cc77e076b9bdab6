"""The kernels of a wheel; .ci/check_installation.py uses a real one."""

import ast
import lzma
import os
import re
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from chain_impact.compilation import browser, compilers, ready
from chain_impact.compilation.library import kernel_library
from chain_impact.compilation.sources import fingerprint
from chain_impact.system import HOST, PLATFORMS
from tests.tiers import needs_compilers

ROOT = Path(__file__).parents[2]


def lower(module, plain=None):
    module.write_text(f"{plain} with derivatives" if plain else "a module")


def compile_kernel(text, compiled, platform, links, *, derivatives, cpu=None):
    assert derivatives == ("derivatives" in text)
    compiled.write_text(f"{text} for {links}" + (f" on {cpu}" if cpu else ""))


def link(compiled, library, platform, *, cpu=None):
    library.write_text(compiled.read_text())


def compile_for_browsers(text, compiled):
    compiled.write_text(f"{text} for a browser")


def link_for_browsers(compiled, module):
    module.write_text(compiled.read_text())


def replace_compilers(monkeypatch):
    """By some that only write files."""
    monkeypatch.setattr(compilers, "prepare_zig", lambda _: None)
    monkeypatch.setattr(compilers, "lower", lower)
    monkeypatch.setattr(compilers, "compile_kernel", compile_kernel)
    monkeypatch.setattr(compilers, "link", link)
    monkeypatch.setattr(browser, "compile_kernel", compile_for_browsers)
    monkeypatch.setattr(browser, "link", link_for_browsers)


@pytest.fixture
def said():
    return []


@pytest.fixture
def made(tmp_path, monkeypatch, said):
    """A folder as a wheel has it."""
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    replace_compilers(monkeypatch)
    assert not ready.all_cached()
    ready.make(tmp_path / "ready", say=said.append)
    monkeypatch.setattr(ready, "FOLDER", tmp_path / "ready")
    ready._usable.cache_clear()
    yield tmp_path / "ready"
    ready._usable.cache_clear()


@needs_compilers
def test_a_second_wheel_of_the_same_sources_takes_no_compiler(made, tmp_path, monkeypatch):
    monkeypatch.setattr(compilers, "lower", None)
    monkeypatch.setattr(compilers, "link", None)
    assert ready.all_cached()
    ready.make(tmp_path / "again")
    first, second = (sorted(path.name for path in folder.iterdir()) for folder in (made, tmp_path / "again"))
    assert first == second


@needs_compilers
def test_there_is_a_kernel_for_every_chain(made):
    assert ready.find(ready.library_name(ready.exact(64), "linux64")).read_text() == "a module for None"
    assert ready.find(ready.library_name(3, "linux64")) is None
    assert kernel_library(4) == kernel_library(64) == ready.find(ready.library_name(None, "linux64"))
    assert ready.find(ready.library_name(None, "win64")) is None
    assert ready.find(browser.MODULE).read_text() == "a module for a browser"
    assert len(ready.libraries()) == len(ready.FIRST_SIZES) + 2  # with derivatives, and for browsers
    assert ready.module() == "a module"
    assert lzma.decompress((made / ready.MODULE).read_bytes()) == b"a module"
    assert not [path for path in made.iterdir() if path.is_dir()]


@needs_compilers
def test_it_is_said_what_is_done(made, said):
    """pip shows these lines: none is long after the one before."""
    assert said[:2] == [
        f"compiling {kind}, for any number of links" for kind in (ready.KERNEL, ready.DERIVATIVES)
    ]
    assert "linking derivatives-any-linux64.so, 2 of 3" in said
    assert len(said) == 4 + len(ready.FIRST_SIZES)


@needs_compilers
def test_who_waits_long_is_told_that_work_goes_on(tmp_path, monkeypatch):
    said = []
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(ready, "PATIENCE", 0.01)
    replace_compilers(monkeypatch)

    def slow(module, plain=None):
        while "still at work" not in said:
            time.sleep(0.01)
        lower(module, plain)

    monkeypatch.setattr(compilers, "lower", slow)
    ready.make(tmp_path / "ready", say=said.append)
    assert said[:2] == ["compiling kernel, for any number of links", "still at work"]


@needs_compilers
@pytest.mark.parametrize("wide", [compilers.WIDE_CPU, None])
def test_derivatives_take_no_compiler(made, monkeypatch, wide):
    """On newer processors, too: the kernel for any processor takes the place of the one for these."""
    monkeypatch.setattr(compilers, "wide_cpu", lambda: wide)
    monkeypatch.setattr(ready, "find_spec", lambda _: None)
    found = ready.find(ready.library_name(None, "linux64", what=ready.DERIVATIVES))
    assert found.read_text() == "a module with derivatives for None"
    for portable in (True, False):
        assert kernel_library(4, derivatives=True, portable=portable) == found


@needs_compilers
def test_a_wheel_for_release_carries_kernels_for_single_numbers_of_links(made, tmp_path, monkeypatch):
    """And one with derivatives for newer processors; what is cached already is not made again."""
    said = []
    assert not ready.all_cached(release=True)
    ready.make(tmp_path / "release", release=True, say=said.append)
    assert ready.all_cached(release=True)
    first = ["any" if size is None else str(size) for size in ready.FIRST_SIZES]
    assert not [line for line in said if any(f"kernel-{size}-" in line for size in first)]
    monkeypatch.setattr(ready, "FOLDER", tmp_path / "release")
    ready._usable.cache_clear()
    assert len(ready.libraries()) == len(ready.SIZES) + 3  # two with derivatives, one for browsers
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "nothing"))
    monkeypatch.setattr(compilers, "wide_cpu", lambda: compilers.WIDE_CPU)
    for links in range(1, ready.LARGEST_EXACT + 1):
        assert kernel_library(links).read_text() == f"a module for {links}"
    for links in (4, 9):
        found = {
            portable: kernel_library(links, derivatives=True, portable=portable).read_text()
            for portable in (True, False)
        }
        assert found[True] == "a module with derivatives for None"
        assert found[False] == f"a module with derivatives for None on {compilers.WIDE_CPU}"
    monkeypatch.setattr(compilers, "wide_cpu", lambda: None)
    assert (
        kernel_library(64, derivatives=True, portable=False).read_text()
        == "a module with derivatives for None"
    )


@pytest.mark.parametrize(
    ("platform", "kinds"),
    [("win64", ["derivatives", "derivatives-wide"]), ("aarch64-linux", ["derivatives"])],
)
def test_a_wheel_has_kernels_for_wide_vectors_where_they_can_be_used(platform, kinds):
    plain = [(ready.KERNEL, size) for size in ready.SIZES]
    first = [(ready.KERNEL, None), (ready.DERIVATIVES, None)]
    assert list(ready._wanted(platform, False).values()) == first
    assert [kind for kind, _ in ready._wanted(platform, True).values()] == ["kernel"] * len(plain) + kinds


@needs_compilers
def test_kernels_of_other_sources_are_not_used(made):
    """As when somebody changes the kernel where it is installed."""
    (made / ready.MADE_FROM).write_text("of before")
    ready._usable.cache_clear()
    assert ready.find(ready.library_name(None, "linux64")) is None
    assert ready.module() is None
    assert ready.libraries() == []
    (made / ready.MADE_FROM).write_text(fingerprint())
    ready._usable.cache_clear()
    assert len(ready.libraries()) > 1


def test_the_compilers_of_a_wheel_are_those_of_the_extra():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    numpy = [requirement for requirement in project["dependencies"] if requirement.startswith("numpy")]
    assert sorted(ready.REQUIREMENTS) == sorted(project["optional-dependencies"]["compiler"] + numpy)


def backend(program, **settings):
    """Run a program with the build backend, where nothing else is installed: as pip runs it."""
    begin = (
        "import sys; sys.path.insert(0, 'packaging');"
        "sys.modules.update(dict.fromkeys(['numpy', 'numba', 'llvmlite', 'ziglang']));"
    )
    command, environment = [sys.executable, "-c", begin + program], {**os.environ, **settings}
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


@needs_compilers
def test_the_build_backend_asks_for_compilers_only_where_they_are_needed(tmp_path):
    program = (
        "import backend;"
        "print(backend.get_requires_for_build_wheel()); print(backend.get_requires_for_build_editable())"
    )
    done = backend(program, CHAIN_IMPACT_CACHE=str(tmp_path))
    wheel, editable = (ast.literal_eval(line) for line in done.stdout.splitlines())
    assert set(ready.REQUIREMENTS) <= set(wheel)
    assert not set(ready.REQUIREMENTS) & set(editable)


@needs_compilers
def test_a_wheel_for_release_needs_compilers_where_only_the_first_kernels_are_cached(made, tmp_path):
    program = "import backend; print(backend.get_requires_for_build_wheel())"
    for release in "01":
        done = backend(program, CHAIN_IMPACT_RELEASE=release)  # in the cache of ``made``
        asked = set(ast.literal_eval(done.stdout))
        assert bool(set(ready.REQUIREMENTS) & asked) == (release == "1")


def test_a_wheel_is_for_this_machine_unless_another_platform_is_named():
    program = "import kernel_hook; print(kernel_hook.target())"
    assert backend(program, CHAIN_IMPACT_PLATFORM="").stdout.strip() == HOST
    assert backend(program, CHAIN_IMPACT_PLATFORM="win64").stdout.strip() == "win64"
    refused = backend(program, CHAIN_IMPACT_PLATFORM="amiga").stderr.splitlines()[-1]
    assert refused.startswith("RuntimeError: CHAIN_IMPACT_PLATFORM = amiga must be one of linux64, win64")
    elsewhere = "from chain_impact import system; system.HOST = '';"
    done = backend(f"import kernel_hook; kernel_hook.kernels(); {elsewhere} kernel_hook.target()")
    assert done.stderr.splitlines()[-1].startswith("RuntimeError: chain-impact runs on Linux ")


def test_a_wheel_of_each_platform_has_a_tag():
    done = backend("import kernel_hook; print(*kernel_hook.TAGS)")
    assert done.stdout.split() == list(PLATFORMS)


def test_an_older_python_is_refused_in_one_sentence():
    done = backend("sys.version_info = (3, 10, 13); import backend")
    assert done.returncode == 1
    assert re.fullmatch(r"chain-impact needs Python 3\.11 or later, and this is \S+ \(\S+\)\n", done.stderr)


def test_the_oldest_python_is_that_of_the_project():
    oldest = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
        "requires-python"
    ]
    done = backend("import backend; print('.'.join(map(str, backend.OLDEST)))")
    assert f">={done.stdout.strip()}" == oldest
