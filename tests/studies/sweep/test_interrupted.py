"""Sweeps that are killed or interrupted: the same command goes on after the finished runs."""

# Tests: studies/sweep/interrupted.py

import json
import signal
import subprocess
import sys
from itertools import islice

import pytest

from chain_impact import cli
from chain_impact.studies.sweep import sweep as module
from chain_impact.studies.sweep.dataset import MANIFEST
from tests.tiers import needs_interop

pytestmark = needs_interop


KILLED = """
import os, signal, sys
from chain_impact.cli import main
from chain_impact.studies.sweep import sweep

real = sweep.run_in_threads

def killed(*arguments):
    batches = real(*arguments)
    for _ in range(3):
        yield next(batches)
    os.kill(os.getpid(), signal.SIGKILL)

sweep.run_in_threads = killed
main(sys.argv[1:])
"""


@pytest.mark.full("takes long")
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows has no such signal")
def test_a_process_that_is_killed_goes_on_after_the_last_complete_file(tmp_path):
    arguments = ["sweep", "--set", "solver.tolerance=1e-6", "--set", "simulation.stop_time=0.6"]
    arguments += ["--vary", "contact.restitution=0.3:0.7:100000", "-o", "runs/"]
    command = [sys.executable, "-c", KILLED, *arguments]
    assert subprocess.run(command, cwd=tmp_path, check=False).returncode == -signal.SIGKILL
    listed = set(json.loads((tmp_path / "runs" / MANIFEST).read_text(encoding="utf-8"))["files"])
    assert len(listed) >= 2
    times = {name: (tmp_path / "runs" / name).stat().st_mtime_ns for name in listed}
    command = [sys.executable, "-m", "chain_impact.cli", *arguments]
    process = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "table    runs/\nFourLinkBox  100000 runs: 100000 ok" in process.stdout
    assert "100000 runs are kept in runs, " in process.stderr
    assert {name: (tmp_path / "runs" / name).stat().st_mtime_ns for name in listed} == times
    assert not list((tmp_path / "runs").glob(".*"))


def test_ctrl_c_says_where_what_is_done_is_kept(tmp_path, monkeypatch, capsys):
    run_in_threads = module.run_in_threads

    def interrupted(*arguments):
        yield next(run_in_threads(*arguments))
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "run_in_threads", interrupted)
    command = ["sweep", "--vary", "contact.restitution=0.3:0.7:50", "-o", f"{tmp_path / 'runs'}/"]
    assert cli.main(command) == 130
    message = capsys.readouterr().err
    assert f"{tmp_path / 'runs'} has the finished runs" in message
    monkeypatch.undo()
    assert cli.main(command) == 0
    assert "FourLinkBox  50 runs: 50 ok" in capsys.readouterr().out


@pytest.fixture(params=[".csv", pytest.param(".parquet", marks=pytest.mark.full("more cases"))])
def interrupted(request, tmp_path, monkeypatch, capsys):
    """Interrupt a command when its table has a part of its rows.

    Check the message, and return command and table.
    """
    table = tmp_path / f"runs{request.param}"
    command = ["sweep", "--vary", "contact.restitution=0.3:0.7:50", "-o", str(table)]
    interrupt(command, monkeypatch)
    assert f"{table} has the finished runs" in capsys.readouterr().err
    return command, table


def interrupt(command, monkeypatch):
    """Interrupt a command after two batches of runs."""
    original_run = module.run_in_threads

    def run_in_threads(*arguments):
        yield from islice(original_run(*arguments), 2)
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(module, "run_in_threads", run_in_threads)
        assert cli.main(command) == 130


def rows_of(table):
    if table.suffix == ".csv":
        return table.read_text("utf-8").splitlines()[1:]
    return pytest.importorskip("pyarrow.parquet").read_table(table).to_pylist()


def test_ctrl_c_keeps_the_rows_that_are_done_and_the_same_command_goes_on(interrupted, monkeypatch):
    command, table = interrupted
    kept_rows = rows_of(table)
    assert 0 < len(kept_rows) < 50
    new_spans, original_run = [], module.run_in_threads
    monkeypatch.setattr(
        module,
        "run_in_threads",
        lambda work, spans, n: new_spans.extend(spans) or original_run(work, spans, n),
    )
    assert cli.main(command) == 0
    assert sum(end - first for first, end in new_spans) == 50 - len(kept_rows)
    assert [path.name for path in table.parent.iterdir()] == [table.name]
    all_rows = rows_of(table)
    assert all(row in all_rows for row in kept_rows)
    assert cli.main([*command[:-1], str(table.with_stem("other"))]) == 0
    assert all_rows == rows_of(table.with_stem("other"))


def test_a_repeated_sweep_that_is_interrupted_leaves_the_complete_table(tmp_path, monkeypatch, capsys):
    table = tmp_path / "runs.csv"
    command = ["sweep", "--vary", "contact.restitution=0.3:0.7:80", "-o", str(table)]
    assert cli.main(command) == 0
    all_rows = rows_of(table)
    for _ in range(2):
        interrupt(command, monkeypatch)
        assert f"{table}.partial has the finished runs" in capsys.readouterr().err
        assert rows_of(table) == all_rows
    assert cli.main(command) == 0
    assert rows_of(table) == all_rows
    assert [path.name for path in tmp_path.iterdir()] == [table.name]


def test_a_sweep_ignores_rows_left_by_another_sweep(interrupted, capsys):
    command, table = interrupted
    kept_rows = rows_of(table)
    assert cli.main([*command, "--set", "contact.stiffness=1e7"]) == 2
    message = (
        f"{table}.partial was left by a sweep that differs in its scene: remove it, or choose another name"
    )
    assert message in capsys.readouterr().err
    assert rows_of(table) == kept_rows
    table.with_name(f"{table.name}.partial").write_bytes(b"PK")
    assert cli.main(command) == 2
    assert "does not come from an interrupted sweep" in capsys.readouterr().err
