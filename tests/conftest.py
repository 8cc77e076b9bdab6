"""The order of the tests, and fixtures of many tests: the command line in an empty folder, and an FMU."""

import filecmp
import gc
import math
import os
import shutil
import sys
import tempfile
from multiprocessing.util import Finalize
from pathlib import Path

import pytest
from xdist.scheduler import LoadFileScheduling

import chain_impact
from chain_impact import cli
from chain_impact.cli import progress
from tests import tiers
from tests.helpers.tools.shared import once, shared_folder
from tests.tiers import pytest_addoption, pytest_cmdline_main, pytest_ignore_collect, pytest_report_header

__all__ = ["pytest_addoption", "pytest_cmdline_main", "pytest_ignore_collect", "pytest_report_header"]

# The slowest files come first, so that all processes end together. Of the first two files, one links plain
# kernels while the other links the kernel with derivatives.
SLOWEST = (
    "tests/scenarios/test_random_scenes.py",
    "tests/simulation/test_derivatives.py",
    "tests/repository/test_docs.py",
    "tests/scenarios/test_derivatives.py",
    "tests/fmu/test_platforms.py",
    "tests/studies/sweep/test_cluster.py",
    "tests/compilation/test_browser.py",
    "tests/pages/test_edit_dialog.py",
    "tests/scenarios/test_law_file.py",
    "tests/fmu/test_fuzzer.py",
    "tests/cli/test_commands.py",
    "tests/fmu/test_build.py",
    "tests/scenarios/test_models.py",
    "tests/pages/test_sliders.py",
    "tests/kernel/test_soundness.py",
)
# file → other file with which the file shares a process, because both use the same results
WITH = {
    f"tests/pictures/test_{name}.py": "tests/pictures/test_overview.py"
    for name in ("committed_pictures", "motion", "over_time", "room")
}


def pytest_configure(config):
    """Set one folder for all temporary files of this session; pytest's own folders stay in place."""
    tiers.pytest_configure(config)
    if hasattr(config, "workerinput"):
        return  # a worker process, which has the settings of its parent
    check_sources(config.rootpath / "fmu_src/chain_impact", Path(chain_impact.__file__).parent)
    # The tests use all cores already: threads of numpy's linear algebra would only wait for one another.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", tempfile.gettempdir())
    folder = tempfile.mkdtemp(prefix="chain-impact-")
    # delete this folder after multiprocessing (priority -100) has deleted its own folder inside
    Finalize(None, shutil.rmtree, (folder, True), exitpriority=-200)
    # an importer unpacks an FMU into a temporary folder, and does not always delete the folder
    os.environ["TMPDIR"] = tempfile.tempdir = folder
    if sys.dont_write_bytecode:
        # keep bytecode although the environment turns this off, because the tests start Python often
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix = f"{folder}/bytecode"
        sys.dont_write_bytecode = False


def check_sources(sources, installed):
    """Refuse to test an installed copy of the package if a source differs from it."""
    names = [str(file.relative_to(sources)) for file in sources.rglob("*.py")]
    _, changed, missing = filecmp.cmpfiles(sources, installed, names, shallow=False)
    if changed or missing:
        raise pytest.UsageError(
            f"{sorted(changed + missing)[0]} is not the file that is installed in {installed}; "
            "repeat the installation, or install with pip's option -e"
        )


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Collect without the collector of garbage, which later ignores the many objects made here."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Let every second process collect from the end, so that each finds half of the files' bytecode."""
    report = yield
    number = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    if isinstance(collector, pytest.Directory) and int(number) % 2:
        report.result.reverse()
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Put the slowest files first, and all other files in the same order in all processes."""
    tiers.leave_out(config, items)
    place = {file: k for k, file in enumerate(SLOWEST)}

    def key(item):
        file = item.nodeid.split("::")[0]
        return place.get(file, len(place)), file

    items.sort(key=key)


class ByFile(LoadFileScheduling):
    """A scheduler that gives each process one file after the other, in this order."""

    def _split_scope(self, nodeid):
        file = super()._split_scope(nodeid)
        return WITH.get(file, file)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Return the scheduler of ``--dist loadfile``, the default (tests/tiers.py)."""
    return ByFile(config, log) if config.getvalue("dist") == "loadfile" else None


@pytest.fixture(scope="session")
def fmu(tmp_path_factory):
    """Return the FMU of the four-link box that `build` makes."""

    def build(folder):
        assert cli.main(["build", "-o", str(folder)]) == 0

    return once(shared_folder(tmp_path_factory, "fmu") / "build", build) / "FourLinkBox.fmu"


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Change to an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run(here, capsys, monkeypatch):
    """Run a command in an empty folder: (exit code, standard output, standard error)."""

    monkeypatch.setattr(progress, "LINES", math.inf)  # tests on slow machines print no lines of progress

    def run(*arguments):
        try:
            code = cli.main([str(argument) for argument in arguments])
        except SystemExit as stop:  # argparse's
            code = stop.code
        return code, *capsys.readouterr()

    return run
