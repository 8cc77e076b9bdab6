"""The kernels of a wheel; .ci/check_installation.py uses a real one."""

import ast
import lzma
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from chain_impact.compilation import compilers, ready
from chain_impact.compilation.sources import fingerprint

ROOT = Path(__file__).parents[2]


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A folder as a wheel has it, by compilers that only write files."""
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(compilers, "prepare_zig", lambda _: None)
    monkeypatch.setattr(compilers, "lower", lambda module: module.write_text("a module"))
    monkeypatch.setattr(
        compilers, "link", lambda text, library, platform, links: library.write_text(f"{text} for {links}")
    )
    assert not ready.all_cached()
    ready.make(tmp_path / "ready")
    monkeypatch.setattr(ready, "FOLDER", tmp_path / "ready")
    ready._usable.cache_clear()
    yield tmp_path / "ready"
    ready._usable.cache_clear()


def test_a_second_wheel_of_the_same_sources_takes_no_compiler(made, tmp_path, monkeypatch):
    monkeypatch.setattr(compilers, "lower", None)
    monkeypatch.setattr(compilers, "link", None)
    assert ready.all_cached()
    ready.make(tmp_path / "again")
    first, second = (sorted(path.name for path in folder.iterdir()) for folder in (made, tmp_path / "again"))
    assert first == second


def test_there_is_a_kernel_for_every_chain(made):
    assert ready.find(ready.library_name(ready.exact(4), "linux64")).read_text() == "a module for 4"
    assert ready.find(ready.library_name(ready.exact(64), "linux64")).read_text() == "a module for None"
    assert ready.find(ready.library_name(4, "win64")) is None
    assert len(ready.libraries()) == ready.LARGEST_EXACT + 1
    assert ready.module() == "a module"
    assert lzma.decompress((made / ready.MODULE).read_bytes()) == b"a module"
    assert not [path for path in made.iterdir() if path.is_dir()]


def test_kernels_of_other_sources_are_not_used(made):
    """As when somebody changes the kernel where it is installed."""
    (made / ready.MADE_FROM).write_text("of before")
    ready._usable.cache_clear()
    assert ready.find(ready.library_name(4, "linux64")) is None
    assert ready.module() is None
    assert ready.libraries() == []
    (made / ready.MADE_FROM).write_text(fingerprint())
    ready._usable.cache_clear()
    assert len(ready.libraries()) > 1


def test_the_compilers_of_a_wheel_are_those_of_the_extra():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    numpy = [requirement for requirement in project["dependencies"] if requirement.startswith("numpy")]
    assert sorted(ready.REQUIREMENTS) == sorted(project["optional-dependencies"]["compiler"] + numpy)


def test_the_build_backend_asks_for_compilers_only_where_they_are_needed(tmp_path):
    """In a process of its own, where nothing else is installed: as pip runs it."""
    program = (
        "import sys; sys.path.insert(0, 'packaging');"
        "sys.modules.update(dict.fromkeys(['numpy', 'numba', 'llvmlite', 'ziglang'])); import backend;"
        "print(backend.get_requires_for_build_wheel()); print(backend.get_requires_for_build_editable())"
    )
    environment = {**os.environ, "CHAIN_IMPACT_CACHE": str(tmp_path)}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    wheel, editable = (ast.literal_eval(line) for line in done.stdout.splitlines())
    assert set(ready.REQUIREMENTS) <= set(wheel)
    assert not set(ready.REQUIREMENTS) & set(editable)
