"""A Python process that has run FMUs by pythonfmu ends well, which guard.c makes sure of.

pythonfmu's wrapper releases its state twice at the end of a process, the second time in freed memory, unless
the slave has released it before.
"""

import os
import signal
import subprocess
from pathlib import Path

import pytest

from tests.fmu.zig import zig

pytestmark = pytest.mark.full("takes long")

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def guard(tmp_path_factory):
    """The library to preload."""
    folder = tmp_path_factory.mktemp("guard")
    zig(folder, "-shared", "-fPIC", HERE / "guard.c", "-o", folder / "guard.so")
    return folder / "guard.so"


FREED = "Instance(one).start().close()"
SEVERAL = """
instances = [Instance(path).start() for path in (one, other) * 2]
instances.append(Instance(one, folder=instances[0].folder).start())
instances.pop(1).close()
Instance(other).start().close()
for instance in instances[1:]:
    instance.fmu.freeInstance()
instances[0].fmu.fmi2FreeInstance(instances[0].fmu.component)
"""
KEPT = """
instances = [Instance(path).start() for path in (one, other)]
for instance in instances:
    shutil.rmtree(instance.folder)
"""
CYCLES = "for path in (one, other) * 5: fmpy.simulate_fmu(path, stop_time=0.01)"
REFUSED = 'assert "not > 0" in refused(one, Instance.start, lambda i: i.fmu.doStep(0.0, -1.0))'
RAISING = 'instance = Instance(one).start(); print("right", flush=True); sys.exit(1)'
NOT_RELEASED = f"{FREED}; import atexit; atexit._clear()"  # as it would be without the slave's doing


@pytest.mark.parametrize(
    ("program", "code"),
    [
        *((program, 0) for program in (FREED, SEVERAL, KEPT, CYCLES, REFUSED)),
        (RAISING, 1),
        (NOT_RELEASED, -signal.SIGSEGV),
    ],
    ids=["freed", "several", "kept", "cycles", "refused", "raising", "not_released"],
)
def test_a_process_ends_well_and_the_guard_sees_where_it_does_not(
    guard, clean_python, all_fmus, program, code
):
    """Guarded, in a process of its own."""
    one, other = (all_fmus["pythonfmu"][model] for model in ("rod_drop", "pinned_arm"))
    lines = ["import shutil, sys", f"sys.path.insert(0, {str(HERE)!r})", "from importer import *"]
    lines += [f"one, other = {one!r}, {other!r}", program, 'print("right")']
    # The value is a list that spaces separate, and a temporary folder may have one in its name.
    environment = os.environ | {"LD_PRELOAD": f"./{guard.name}"}
    command = [clean_python, "-I", "-c", "\n".join(lines)]
    done = subprocess.run(
        command, cwd=guard.parent, env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (code, "right\n"), done.stderr[-2000:]
