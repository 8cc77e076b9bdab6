"""The settings of a session, and fixtures of many tests: the command line in an empty folder, and an FMU."""

import math
import os
import shutil
import sys
import tempfile
from multiprocessing.util import Finalize
from pathlib import Path

import pytest

import chain_impact
from chain_impact import cli
from chain_impact.cli import progress_bar
from tests.helpers.tools.fakes import CheckedPatch
from tests.helpers.tools.shared import make_once, shared_folder
from tests.helpers.tools.sources import check_sources

pytest_plugins = ["tests.tiers", "tests.scheduling"]


def pytest_configure(config):
    """Check the package, and set threads, bytecode and one folder for temporary files of this session.

    pytest's own folders stay in place.
    """
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
        # Keep bytecode although the environment turns this off, because tests start Python often. It stays
        # for the next session, as half of the time of collecting tests is that of their bytecode.
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        bytecode = config.rootpath / ".pytest_cache" / "bytecode"
        os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix = str(bytecode)
        sys.dont_write_bytecode = False


@pytest.fixture
def monkeypatch():
    """Return pytest's ``monkeypatch``, which checks fakes of the package's functions."""
    with CheckedPatch.context() as patch:
        yield patch


@pytest.fixture(scope="session")
def fmu(tmp_path_factory):
    """Return the FMU of the four-link box that `build` makes."""

    def build(folder):
        assert cli.main(["build", "-o", str(folder)]) == 0

    return make_once(shared_folder(tmp_path_factory, "fmu") / "build", build) / "FourLinkBox.fmu"


@pytest.fixture
def work_folder(tmp_path, monkeypatch):
    """Change to an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run(work_folder, capsys, monkeypatch):
    """Run a command in an empty folder: (exit code, standard output, standard error)."""

    # tests on slow machines print no lines of progress
    monkeypatch.setattr(progress_bar, "LINE_INTERVAL", math.inf)

    def run(*arguments):
        try:
            code = cli.main([str(argument) for argument in arguments])
        except SystemExit as stop:  # argparse's
            code = stop.code
        return code, *capsys.readouterr()

    return run
