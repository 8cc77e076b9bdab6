"""The progress bar."""

import re
import time

from chain_impact.cli import bar, progress
from chain_impact.compilation.work import Part, Work
from tests.cli.terminal import compiling

LITTLE_WORK = "solver.work_limit=1500"  # too little for the impacts, enough for the flight before


def until(holds):
    """Wait until something holds, however slow the machine is."""
    patience = time.monotonic() + 600.0
    while not holds():
        assert time.monotonic() < patience
        time.sleep(0.01)


def test_a_bar_shows_on_a_terminal_while_something_compiles(run, monkeypatch, terminal):
    compiling(monkeypatch)
    text = terminal(True)
    assert run("simulate", "rod_drop")[0] == 0
    assert "compiling the kernel" in text.getvalue()
    assert text.getvalue().endswith("\x1b[2K")  # and is wiped out


def test_the_bar_returns_to_the_simulation_after_a_second_compilation(monkeypatch, terminal):
    monkeypatch.setattr(bar, "BRIEF", 0.0)
    text = terminal(True)
    with progress.progress() as (notify, advance):
        advance(0.1)
        notify(Work("linking", 3.0))
        advance(0.5)
        until(lambda: "simulating" in text.getvalue().split("linking")[-1])


def test_no_bar_when_nothing_compiles(run, terminal):
    text = terminal(True)
    run("simulate", "rod_drop")
    assert text.getvalue() == ""


def test_the_bar_moves_as_long_as_it_compiles(monkeypatch, terminal):
    text = terminal(True)

    def lengths():
        shown = re.findall("━+", re.sub(r"\x1b\[38;[\d;]*m━+|\x1b\[0m", "", text.getvalue()))
        return {len(bar) for bar in shown}

    with progress.progress() as (notify, _):
        notify(Work("compiling the kernel", 60.0))
        until(lambda: len(lengths()) >= 2)
    assert "of about 60 s" in text.getvalue()


def test_the_bar_says_what_is_being_done(run, terminal):
    text = terminal(True)
    run("build", "rod_drop")
    assert "packaging the FMU" in text.getvalue()
    assert "validating the FMU" in text.getvalue()


def test_a_fault_below_the_bar_is_still_one_line(run, monkeypatch, terminal):
    compiling(monkeypatch)
    text = terminal(True)
    assert run("simulate", "--set", LITTLE_WORK)[0] == 3
    assert (
        text.getvalue().split("\x1b[2K")[-1].startswith("chain-impact: FourLinkBox: the simulation stopped")
    )


def test_a_terminal_shows_how_many_are_done(monkeypatch, terminal):
    monkeypatch.setattr(bar, "BRIEF", 0.0)
    monkeypatch.setattr(progress.out, "quiet", False)
    text = terminal(True)
    with progress.progress("sweeping") as (_, advance):
        advance(Part(300, 800))
        until(lambda: "sweeping, 300 of 800" in text.getvalue())
