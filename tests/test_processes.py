"""A helper process that dies or hangs is a test that fails with a reason, and does not hang itself."""

import sys

import pytest

from tests import processes
from tests.processes import Processes


@pytest.fixture
def helpers(tmp_path):
    (tmp_path / "broken.py").write_text("raise SystemExit('no use')\n")
    (tmp_path / "sound.py").write_text("import time\n")
    helpers = Processes(tmp_path, tmp_path, sys.executable)
    yield helpers
    helpers.end()


def doubled(value):
    return 2 * value


def slow():
    time.sleep(3.0)  # noqa: F821


def test_a_process_that_dies_is_shown_with_what_it_has_said(helpers):
    for _ in range(2):
        with pytest.raises(AssertionError, match=r"the process that imports broken has died:\nno use"):
            helpers.run(doubled, 2, module="broken")


def test_a_process_that_gives_no_answer_is_ended(helpers, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(processes, "PATIENCE", 0.5)
        with pytest.raises(AssertionError, match=r"the process that imports sound gave no answer in 0\.5 s"):
            helpers.run(slow, module="sound")
    assert helpers.run(doubled, 2, module="sound") == 4
