"""CPU seconds of each test and of its processes: ``python -m pytest -p tests.helpers.tools.cpu_profile``.

CPU times hardly depend on the load of the machine, in contrast to the times of ``--durations``. The time of a
fixture counts for the test that uses it first, and the time of a process for the test in which it ends.
"""

import os
from collections import Counter
from itertools import chain

import pytest

SHOWN = 30
counted = {"until": 0.0}


def spent():
    """Return the CPU seconds of this process, and of its child processes that have ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def pytest_collection_finish():
    """Begin to count after the collection of tests."""
    counted["until"] = spent()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport():
    """Store the CPU seconds since the last report in the report of this phase of a test."""
    report = yield
    report.cpu = spent() - counted["until"]
    counted["until"] += report.cpu
    return report


def pytest_terminal_summary(terminalreporter):
    """List the phases of tests (set-up, call, teardown) and the files with the most CPU seconds."""
    tests, files = Counter(), Counter()
    reports = chain.from_iterable(terminalreporter.stats.values())
    for report in (outcome for outcome in reports if hasattr(outcome, "cpu")):
        tests[f"{report.when:8} {report.nodeid}"] += report.cpu
        files[report.nodeid.split("::")[0]] += report.cpu
    for table in (tests, files):
        terminalreporter.section(f"CPU seconds, of {sum(table.values()):.0f}")
        for name, seconds in table.most_common(SHOWN):
            terminalreporter.write_line(f"{seconds:7.2f}  {name}")
