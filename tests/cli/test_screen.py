"""What the command line prints of a comparison; of simulations, test_commands.py."""

import math
from dataclasses import replace

from chain_impact import CONTACT_LAWS, compare
from chain_impact.cli.screen import law_table
from tests.problems import default_scene


def test_an_impulse_and_a_law_without_a_result_have_a_row():
    comparison = compare(default_scene())
    hertz, *others = comparison.runs
    impulse = replace(hertz, duration=0.0, max_penetration=0.0, peak_force=math.inf)
    failed = replace(
        others[0], result=None, note="cannot start", **dict.fromkeys(("restitution", "peak_force"), math.nan)
    )
    lines = list(law_table(replace(comparison, runs=(impulse, failed, *others[1:]))))
    first, second = (next(line for line in lines if line.startswith(run.law)) for run in (impulse, failed))
    assert first.split()[2:5] == ["∞", "0.000", "0.000"]
    assert second.split()[1:3] == ["–", "–"]
    assert second.endswith("  –  cannot start")


def test_the_columns_are_aligned():
    head, *rows = list(law_table(compare(default_scene())))[1 : 2 + len(CONTACT_LAWS)]
    end = head.replace("[bold]", "").index("steps") + len("steps")
    assert [row.split()[0] for row in rows] == list(CONTACT_LAWS)
    assert all(len(row) == end or row[end] == " " for row in rows)
