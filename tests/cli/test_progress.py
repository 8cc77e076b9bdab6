"""What is said on standard error while something takes long."""

import pickle

from chain_impact.cli import progress
from chain_impact.compilation.work import Part, Work
from tests.cli.terminal import compiling


def test_a_sentence_about_work_goes_to_another_process():
    work = pickle.loads(pickle.dumps(Work("compiling", 12.0)))
    assert (work, work.seconds) == ("compiling", 12.0)


def test_a_line_instead_of_a_bar_in_a_file(run, monkeypatch, terminal):
    text = terminal(False)
    with monkeypatch.context() as patch:
        compiling(patch)
        _, _, errors = run("simulate", "rod_drop")
    assert errors == "chain-impact: compiling the kernel (about 17 s, then kept)\n"
    _, _, errors = run("build", "rod_drop")
    assert errors == ""  # of what takes a moment nothing is said
    assert text.getvalue() == ""


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
