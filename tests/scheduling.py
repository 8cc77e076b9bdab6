"""The order in which tests are collected and run, and the processes that run them."""

import gc
import os
import sys

import pytest
from xdist.scheduler import LoadFileScheduling

from tests import tiers

# The slowest files come first, by their CPU seconds, so that all processes end together. Of the first two
# files, one links plain kernels while the other links the kernel with derivatives. Files of pages stay in
# their room, which has one browser in each process.
SLOWEST = (
    "tests/scenarios/test_random_scenes.py",
    "tests/simulation/test_derivatives.py",
    "tests/pictures/motion/test_motion.py",  # and the files that share its process
    "tests/fmu/test_platforms.py",
    "tests/repository/test_docs.py",
    "tests/scenarios/test_derivatives.py",
    "tests/fmu/test_fuzzer.py",
    "tests/scenarios/test_carried_arm.py",
    "tests/studies/sweep/test_cluster.py",
    "tests/studies/sweep/test_batches.py",
    "tests/fmu/test_parameters.py",
    "tests/fmu/test_interface.py",
    "tests/scenarios/test_certificate.py",
    "tests/studies/sweep/test_interrupted.py",
    "tests/compilation/test_browser.py",
    "tests/scenarios/test_law_file.py",
    "tests/cli/test_commands.py",
    "tests/fmu/test_build.py",
    "tests/repository/test_search.py",
    "tests/scenarios/test_arches.py",
    "tests/scenarios/test_models.py",
    "tests/kernel/test_soundness.py",
)
# number of new objects after which garbage is collected; Python's 700 take a tenth of the time of a picture
GARBAGE = 50_000
# file → other file with which the file shares a process, because both use the same results
SHARED_PROCESS = {
    f"tests/pictures/{name}.py": "tests/pictures/test_overview.py"
    for name in (
        "motion/test_motion",
        "motion/test_walls",
        "over_time/test_dry_friction",
        "over_time/test_energies",
        "over_time/test_impacts",
        "test_committed_pictures",
        "test_overview_layout",
    )
}


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Collect without the collector of garbage, which later runs rarely, and ignores the objects made here.

    If a test needs matplotlib, it is imported now, and keeps the layouts of texts and the ticks of axes.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(GARBAGE, 20, 20)
        gc.enable()
        if "matplotlib.text" in sys.modules:
            from tests.helpers.tools.text_layouts import keep_layouts
            from tests.helpers.tools.tick_layouts import keep_ticks

            keep_layouts()
            keep_ticks()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Let every second process collect from the end, so that each finds half of the files' bytecode."""
    report = yield
    number = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    if isinstance(collector, pytest.Directory) and int(number) % 2:
        report.result.reverse()
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Leave out the tests that are not in the tier, and put the slowest files first.

    All other files follow in the same order in all processes.
    """
    tiers.leave_out(config, items)
    place = {file: k for k, file in enumerate(SLOWEST)}

    def key(item):
        file = item.nodeid.split("::")[0]
        return place.get(file, len(place)), file

    items.sort(key=key)


class ByFile(LoadFileScheduling):
    """A scheduler that gives each process one file after the other, in this order."""

    def _split_scope(self, nodeid):
        file = super()._split_scope(nodeid)
        return SHARED_PROCESS.get(file, file)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Return the scheduler of ``--dist loadfile``, the default (tests/tiers.py)."""
    return ByFile(config, log) if config.getvalue("dist") == "loadfile" else None
