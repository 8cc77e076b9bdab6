"""A value that an FMU for FMI 2.0 refuses, under libcosim, a multithreaded master in C++.

tests/scenarios/test_controlled_arm.py tests the results of masters that connect FMUs.
"""

# Tests: fmu/build.py

import subprocess
import sys

import fmpy
import pytest

from tests.tiers import needs_interop

PROGRAM = """
import sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimSlave import CosimLocalSlave

fmu, reference, when = sys.argv[1], int(sys.argv[2]), sys.argv[3]

def execution():
    slave = CosimLocalSlave(fmu, "chain")
    new = CosimExecution.from_step_size(1_000_000)
    return new, slave, new.add_local_slave(slave)

one, slave, place = execution()
if when == "start":
    one.real_initial_value(place, reference, 2.0)
else:
    manipulator = CosimManipulator.create_override()
    one.add_manipulator(manipulator)
    assert one.step(5)
    manipulator.slave_real_values(place, [reference], [2.0])
assert not one.step()
del one
two, *_ = execution()
assert two.step(5)
print("lives on")
"""


@needs_interop
@pytest.mark.parametrize("when", ["start", "run"])
def test_libcosim_says_which_value_was_refused_and_lives_on(fmi2, when):
    """libcosim runs the FMU again. Before the first step its threads catch no error, and the process ends."""
    variables = {v.name: v for v in fmpy.read_model_description(fmi2["rod_drop"]).modelVariables}
    reference = str(variables["contact.restitution"].valueReference)
    command = [sys.executable, "-c", PROGRAM, fmi2["rod_drop"], reference, when]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    sentence = "fmi2SetReal: contact.restitution = 2.0 must be a finite number >= 0 and <= 1"
    assert sentence in done.stdout + done.stderr
    if when == "run":
        assert done.returncode == 0, done.stderr[-2000:]
        assert "\nlives on\n" in done.stdout
