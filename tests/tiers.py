"""Two tiers of tests: ``pytest`` runs the quick one, without compilers and browsers, ``pytest --full`` all.

``@pytest.mark.full(reason)`` puts a test into the second tier only, but for some cases: ``but="rod_drop"`` is
the id of a case that stays in the first tier, ``but=["flores", "hertz"]`` are several, and ``but=3`` are the
first three. A test named by its node id on the command line always runs.
"""

import os
import re
import shutil
import tomllib
from collections import defaultdict
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from itertools import chain
from pathlib import Path

import pytest
from hypothesis import settings

from chain_impact.system import cores

MOST_WORKERS = 8
TESTS = Path(__file__).parent
SOURCES = TESTS.parent / "fmu_src" / "chain_impact"
"""The package's sources. An installed package has files of its own beside them."""
EXTRAS = {
    extra: [
        re.match(r"[\w-]+", requirement)[0]
        for requirement in all_needed
        if not requirement.startswith("chain-impact")
    ]
    for extra, all_needed in tomllib.loads((TESTS.parent / "pyproject.toml").read_text(encoding="utf-8"))[
        "project"
    ]["optional-dependencies"].items()
    if extra != "bench"  # only benchmarks need it
}
"""Extra that ``pytest --full`` needs → the packages that it adds, without those of extras that it names."""
CHROMIUMS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
CHROMIUM = next(filter(None, map(shutil.which, CHROMIUMS)), None)
"""The first Chromium that is installed; one without windows opens a page in three quarters of the time."""
FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")

needs_browser = pytest.mark.full("needs browsers")
needs_compilers = pytest.mark.full("needs compilers")
needs_interop = pytest.mark.full("needs other tools")
ALL_FULL = re.compile(
    r'^pytestmark = (needs_(browser|compilers|interop)|pytest\.mark\.full\("[^"]*"\))$', re.MULTILINE
)
"""Matches the line that puts all tests of a file into the second tier."""

IMPORTING = {
    "flint": ["test_certificate.py"],
    "mujoco": ["test_mjcf_fields.py", "test_beside_mujoco.py"],
    "numba": ["test_dual_numbers.py", "test_lower.py", "test_record_type.py"],
    "nbconvert": ["test_notebook.py"],
    "yaml": ["test_workflows.py"],
}
"""Module that the quick tier does not need → test files that import the module."""


def pytest_addoption(parser):
    """Add the options that choose a tier, or a module of the package."""
    parser.addoption(
        "--of", metavar="MODULE", help="run only the files that test a module, such as kernel/advance.py"
    )
    parser.addoption("--full", action="store_true", help="run all tests; needs the extra dev, and browsers")
    parser.addoption(
        "--without-quick", action="store_true", help="with --full: leave out the tests that pytest has run"
    )


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config):
    """Use all cores unless the number of processes is given; each process runs one file after the other."""
    options, worker = config.option, hasattr(config, "workerinput")
    if (
        config.pluginmanager.hasplugin("xdist")
        and not worker
        and options.numprocesses is None
        and not options.usepdb
    ):
        options.numprocesses = min(cores(), MOST_WORKERS)
        options.dist, options.loadscopereorder, options.maxworkerrestart = "loadfile", False, "0"


def pytest_configure(config):
    """Declare the marker, refuse impossible options, and fix the random examples of the quick tier."""
    if config.option.of and not (SOURCES / config.option.of).is_file():
        raise pytest.UsageError(f"--of {config.option.of} must be a module of the package: kernel/advance.py")
    config.addinivalue_line("markers", "full(reason, but=0): only in pytest --full, but for some cases")
    if config.option.without_quick and not config.option.full:
        raise pytest.UsageError("--without-quick needs --full")
    if config.option.full:
        refuse_what_is_missing()
    random = config.option.full and "CI" not in os.environ
    settings.register_profile("chain-impact", deadline=None, derandomize=not random)
    settings.load_profile("chain-impact")


def is_installed(package):
    """Return whether a package is installed, by its name in a registry."""
    return any(metadata.distributions(name=package))


def refuse_what_is_missing():
    """Raise an error with one sentence that names everything missing for --full."""
    extras = [extra for extra, packages in EXTRAS.items() if not all(map(is_installed, packages))]
    if extras:
        lacking_tools = f"the extras {', '.join(extras)}, which are not installed: pip install -e '.[dev]'"
    elif not (CHROMIUM and FIREFOX):
        lacking_tools = "Chromium and Firefox: sudo apt-get install chromium-headless-shell firefox-esr"
    else:
        return
    raise pytest.UsageError(f"--full needs {lacking_tools}")


def pytest_report_header(config):
    """Return the name of the tier for the header."""
    return "all tests" if config.option.full else "the quick tier of the tests; all of them: pytest --full"


def pytest_ignore_collect(collection_path, config):
    """Leave out files that cannot be imported, that do not test the module of ``--of``, or are not quick.

    Files that are not quick are only left out if the command line names no file.
    """
    module, is_test = config.option.of, collection_path.match("test_*.py")
    if module and is_test and module not in subjects(collection_path):
        return True
    folders = all((config.invocation_params.dir / name).is_dir() for name in config.args)
    if is_test and folders and not config.option.full and not has_quick_tests(collection_path):
        return True
    return collection_path.name in not_importable() or None


def has_quick_tests(file):
    """Return whether some tests of a file may be in the quick tier."""
    text = file.read_text(encoding="utf-8")
    return "but=" in text or not ALL_FULL.search(text)


def subjects(file):
    """Return the modules that a file tests: the one of its name, and those of its lines ``# Tests:``."""
    lines = re.findall(r"^# Tests: (.+)$", file.read_text(encoding="utf-8"), re.MULTILINE)
    own_module = file.relative_to(TESTS).with_name(file.name.removeprefix("test_")).as_posix()
    return [name for line in lines for name in line.split(", ")] + [own_module] * (
        SOURCES / own_module
    ).is_file()


@cache
def not_importable():
    """Return the names of test files that cannot be imported."""
    return {name for module, names in IMPORTING.items() if find_spec(module) is None for name in names}


@cache
def not_in_quick_tier():
    """Return the names of test files that the README's environment cannot import; it has the compilers."""
    return set(chain.from_iterable(IMPORTING[name] for name in IMPORTING.keys() - {*EXTRAS["compiler"]}))


def leave_out(config, items):
    """Leave out the tests that are not in the tier."""
    if config.option.full and not config.option.without_quick:
        return
    named_items = [argument for argument in config.args if "::" in argument]
    exempted = {}
    cases, quick, full = defaultdict(list), [], []
    for item in items:
        mark = item.get_closest_marker("full")
        if mark and not any(is_named(item, name) for name in named_items):
            function = re.sub(r"\[.*", "", item.nodeid)
            cases[function].append(case := item.nodeid[len(function) + 1 : -1])
            but = exempt(mark, item)
            is_quick = len(cases[function]) <= but if isinstance(but, int) else case in but
            (quick if is_quick else full).append(item)
            exempted[function] = {*but} if isinstance(but, list) else set()
        elif config.option.full and item.path.name in not_in_quick_tier():
            full.append(item)
        else:
            quick.append(item)
    if missing_cases := [f"{test}[{case}]" for test in exempted for case in exempted[test] - {*cases[test]}]:
        raise pytest.UsageError(f"no such case: {', '.join(missing_cases)}")
    chosen_items, left_out = (full, quick) if config.option.full else (quick, full)
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = chosen_items


def is_named(item, name):
    """Return whether a node id of the command line is the id of a test, or of its function."""
    return item.nodeid == name or item.nodeid.startswith(f"{name}[")


def exempt(mark, item):
    """Return the cases of a marked test in the quick tier: the number of the first ones, or a list of ids."""
    if len(mark.args) != 1 or not isinstance(mark.args[0], str) or mark.kwargs.keys() - {"but"}:
        raise pytest.UsageError(f'{item.nodeid}: the marker must be full("reason") or full("reason", but=3)')
    but = mark.kwargs.get("but", 0)
    return [but] if isinstance(but, str) else but
