"""Progress messages on standard error and in a terminal during long computations."""

# Tests: progress.py, cli/printing.py, cli/progress_bar.py

import logging
import time

from chain_impact.cli import printing, progress_bar
from chain_impact.progress import log, log_once
from tests.cli.terminal import compiling

LITTLE_WORK = "solver.work_limit=1500"  # work units: enough for the first flight, too few for the impacts


def until(holds):
    """Wait until a condition holds, at any speed of the machine."""
    patience = time.monotonic() + 600.0
    while not holds():
        assert time.monotonic() < patience
        time.sleep(0.01)


def test_a_library_prints_nothing_and_leaves_the_log_to_its_user(capfd):
    log_once("compiling", 12.0)
    assert capfd.readouterr() == ("", "")
    assert log.level == logging.NOTSET
    with progress_bar.progress():
        pass
    assert (log.level, len(log.handlers)) == (logging.NOTSET, 1)


def test_a_line_instead_of_a_bar_in_a_file(run, monkeypatch, terminal):
    text = terminal(False)
    with monkeypatch.context() as patch:
        compiling(patch)
        run("simulate", "rod_drop")
    assert text.getvalue() == "chain-impact: compiling the kernel (about 17 s, then kept)\n"
    run("build", "rod_drop")
    assert text.getvalue().count("\n") == 1  # a short computation prints no message


def test_quiet_says_nothing_of_compiling_but_still_what_is_wrong(run, monkeypatch, terminal):
    compiling(monkeypatch)
    text = terminal(True)
    assert run("simulate", "rod_drop", "-q") == (0, "", "")
    assert text.getvalue() == ""
    text = terminal(False)
    assert run("simulate", "no_scene", "-q")[:2] == (2, "")
    assert text.getvalue().startswith("chain-impact: no_scene: cannot be read")


def test_without_a_terminal_long_work_writes_a_line_now_and_then(monkeypatch, terminal):
    now = [0.0]
    monkeypatch.setattr(progress_bar, "monotonic", lambda: now[0])
    monkeypatch.setattr(printing.out, "quiet", False)
    text = terminal(False)
    with progress_bar.progress("sweeping") as advance:
        for percent in range(1, 101):
            now[0] += 0.5
            advance(percent / 100)
    lines = [f"chain-impact: sweeping, {percent} %" for percent in (20, 40, 60, 80, 100)]
    assert text.getvalue().splitlines() == lines


def test_a_bar_shows_on_a_terminal_while_something_compiles(run, monkeypatch, terminal):
    text = terminal(True)
    run("simulate", "rod_drop")
    assert text.getvalue() == ""
    compiling(monkeypatch)
    assert run("simulate", "rod_drop")[0] == 0
    assert "compiling the kernel (about 17 s" in text.getvalue()
    assert text.getvalue().endswith("\x1b[2K")  # the line is erased at the end


def test_the_bar_returns_to_the_simulation_after_a_second_compilation(monkeypatch, terminal):
    monkeypatch.setattr(progress_bar, "BAR_DELAY", 0.0)
    text = terminal(True)
    with progress_bar.progress() as advance:
        advance(0.1)
        log_once("linking", 3.0)
        advance(0.5)
        until(lambda: "simulating, 50 %" in text.getvalue().split("linking")[-1])


def test_the_bar_says_what_is_being_done(run, terminal):
    text = terminal(True)
    run("build", "rod_drop")
    assert "packaging the FMU" in text.getvalue()
    assert "validating the FMU" in text.getvalue()


def test_a_fault_below_the_bar_is_still_one_line(run, monkeypatch, terminal):
    compiling(monkeypatch)
    text = terminal(True)
    assert run("simulate", "--set", LITTLE_WORK)[0] == 3
    last = text.getvalue().split("\x1b[2K")[-1]
    assert last.startswith("chain-impact: FourLinkBox: the simulation stopped")
