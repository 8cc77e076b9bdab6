"""A Python process that has run FMUs by pythonfmu ends well, which guard.c makes sure of.

pythonfmu's wrapper releases its state twice at the end of a process, the second time in freed memory, unless
the slave has released it before.
"""

import inspect
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import fmpy
import pytest

from tests.fmu.importer import Instance, refused
from tests.fmu.zig import zig

pytestmark = pytest.mark.full("takes long")

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def guard(tmp_path_factory):
    """The library to preload."""
    folder = tmp_path_factory.mktemp("guard")
    zig(folder, "-shared", "-fPIC", HERE / "guard.c", "-o", folder / "guard.so")
    return folder / "guard.so"


@pytest.fixture
def ended(guard, clean_python, all_fmus):
    """How a process ends, guarded, that calls ``function(paths of two FMUs)``: code, output."""
    fmus = [all_fmus["pythonfmu"][model] for model in ("rod_drop", "pinned_arm")]

    def ended(function, preload=guard):
        lines = (
            "import shutil, sys",
            f"sys.path.insert(0, {str(HERE)!r})",
            "from importer import *",
            inspect.getsource(function),
            f"{function.__name__}({fmus!r})",
        )
        command = [clean_python, "-I", "-c", "\n".join(lines)]
        # The value is a list that spaces separate, and a temporary folder may have one in its name.
        environment = os.environ | {"LD_PRELOAD": preload and f"./{guard.name}"}
        done = subprocess.run(
            command, cwd=guard.parent, env=environment, capture_output=True, text=True, check=False
        )
        return done.returncode, done.stdout

    return ended


# Each of these runs in a process of its own, which ends after it.


def freed(fmus):
    Instance(fmus[0]).start().close()
    print("right")


def several(fmus):
    """Two FMUs, each unpacked several times, and once made twice from a folder."""
    instances = [Instance(path).start() for path in fmus * 2]
    instances.append(Instance(fmus[0], folder=instances[0].folder).start())
    instances.pop(1).close()
    Instance(fmus[1]).start().close()
    for instance in instances[1:]:
        instance.fmu.freeInstance()
    instances[0].fmu.fmi2FreeInstance(instances[0].fmu.component)
    print("right")


def kept(fmus):
    """Nobody frees them, and their folders are gone."""
    global instances  # noqa: PLW0603
    instances = [Instance(path).start() for path in fmus]
    for instance in instances:
        shutil.rmtree(instance.folder)
    print("right")


def cycles(fmus):
    for path in fmus * 5:
        fmpy.simulate_fmu(path, stop_time=0.01)
    print("right")


def refused_step(fmus):
    print(
        "right"
        if "not > 0" in refused(fmus[0], Instance.start, lambda i: i.fmu.doStep(0.0, -1.0))
        else "wrong"
    )


def raising(fmus):
    global instance  # noqa: PLW0603
    instance = Instance(fmus[0]).start()
    print("right")
    sys.exit(1)


def not_released(fmus):
    """As it would be without the slave's doing."""
    import atexit

    Instance(fmus[0]).start().close()
    atexit._clear()
    print("right")


@pytest.mark.parametrize("host", [freed, several, kept, cycles, refused_step])
def test_a_process_ends_well(ended, host):
    assert ended(host) == (0, "right\n")


def test_a_process_ends_as_it_would_after_an_error(ended):
    assert ended(raising) == (1, "right\n")


def test_the_guard_sees_a_state_that_is_released_twice(ended):
    assert ended(not_released) == (-signal.SIGSEGV, "right\n")
