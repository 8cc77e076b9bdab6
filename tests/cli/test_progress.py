"""The progress bar, and what is said on standard error while something takes long."""

import io
import pickle
import re
import time

import pytest
from rich.console import Console

from chain_impact.cli import progress
from chain_impact.compilation.work import Part, Work
from chain_impact.simulation import instance

LITTLE_WORK = "solver.work_limit=1500"  # too little for the impacts, enough for the flight before


@pytest.fixture
def terminal(monkeypatch):
    """What is printed for the eyes of a terminal's user on standard error."""

    def terminal(is_one):
        text = io.StringIO()
        console = Console(file=text, force_terminal=is_one, width=100)
        monkeypatch.setattr(progress, "err", console)
        return text

    return terminal


def until(holds):
    """Wait until something holds, however slow the machine is."""
    patience = time.monotonic() + 600.0
    while not holds():
        assert time.monotonic() < patience
        time.sleep(0.01)


def compiling(monkeypatch):
    """Let the cached kernel look as if it had to be compiled."""
    cached = instance.kernel_library

    def kernel_library(*arguments, notify, **_):
        notify(Work("compiling the kernel", 17.0))
        return cached(*arguments)

    monkeypatch.setattr(instance, "kernel_library", kernel_library)
    monkeypatch.setattr(instance, "_loaded", {})


def test_a_bar_shows_on_a_terminal_while_something_compiles(run, monkeypatch, terminal):
    compiling(monkeypatch)
    text = terminal(True)
    assert run("simulate", "rod_drop")[0] == 0
    assert "compiling the kernel" in text.getvalue()
    assert text.getvalue().endswith("\x1b[2K")  # and is wiped out


def test_a_sentence_about_work_goes_to_another_process():
    work = pickle.loads(pickle.dumps(Work("compiling", 12.0)))
    assert (work, work.seconds) == ("compiling", 12.0)


def test_the_bar_returns_to_the_simulation_after_a_second_compilation(monkeypatch, terminal):
    monkeypatch.setattr(progress, "BRIEF", 0.0)
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


def test_a_line_instead_of_a_bar_in_a_file(run, monkeypatch, terminal):
    text = terminal(False)
    with monkeypatch.context() as patch:
        compiling(patch)
        _, _, errors = run("simulate", "rod_drop")
    assert errors == "chain-impact: compiling the kernel (about 17 s, then kept)\n"
    _, _, errors = run("build", "rod_drop")
    assert errors == ""  # of what takes a moment nothing is said
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


def test_quiet_still_says_what_is_wrong(run, monkeypatch, terminal):
    text = terminal(False)
    assert run("simulate", "no_scene", "-q")[:2] == (2, "")
    assert text.getvalue().startswith("chain-impact: no_scene: cannot be read")


def test_quiet_says_nothing_of_compiling(run, monkeypatch, terminal):
    compiling(monkeypatch)
    text = terminal(True)
    assert run("simulate", "rod_drop", "-q") == (0, "", "")
    assert text.getvalue() == ""


def test_without_a_terminal_long_work_writes_a_line_now_and_then(monkeypatch, terminal, capsys):
    now = [0.0]
    monkeypatch.setattr(progress, "monotonic", lambda: now[0])
    monkeypatch.setattr(progress.out, "quiet", False)
    terminal(False)
    with progress.progress("sweeping") as (_, advance):
        for done in range(1, 101):
            now[0] += 0.5
            advance(Part(done, 100))
    assert capsys.readouterr().err.splitlines() == [
        f"chain-impact: sweeping, {done} of 100" for done in (20, 40, 60, 80, 100)
    ]


def test_a_terminal_shows_how_many_are_done(monkeypatch, terminal):
    monkeypatch.setattr(progress, "BRIEF", 0.0)
    monkeypatch.setattr(progress.out, "quiet", False)
    text = terminal(True)
    with progress.progress("sweeping") as (_, advance):
        advance(Part(300, 800))
        until(lambda: "sweeping, 300 of 800" in text.getvalue())
