"""The command line, run in an empty folder, and an FMU for it."""

import pytest

from chain_impact import cli
from tests.shared import once, shared_folder


@pytest.fixture(scope="session")
def fmu(tmp_path_factory):
    """The FMU of the four-link box, as `build` makes it."""

    def build(folder):
        assert cli.main(["build", "-o", str(folder)]) == 0

    return once(shared_folder(tmp_path_factory, "fmu") / "build", build) / "FourLinkBox.fmu"


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder to be in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run(here, capsys):
    """Run a command in an empty folder: (exit code, standard output, standard error)."""

    def run(*arguments):
        try:
            code = cli.main([str(argument) for argument in arguments])
        except SystemExit as stop:  # argparse's
            code = stop.code
        return code, *capsys.readouterr()

    return run
