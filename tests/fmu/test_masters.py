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
    cosim = CosimExecution.from_step_size(1_000_000)
    return cosim, slave, cosim.add_local_slave(slave)

first, slave, place = execution()
if when == "start":
    first.real_initial_value(place, reference, 2.0)
else:
    manipulator = CosimManipulator.create_override()
    first.add_manipulator(manipulator)
    assert first.step(5)
    manipulator.slave_real_values(place, [reference], [2.0])
assert not first.step()
del first
second, *_ = execution()
assert second.step(5)
print("lives on")
"""


@needs_interop
@pytest.mark.parametrize("when", ["start", "run"])
def test_libcosim_says_which_value_was_refused_and_lives_on(fmi2, when):
    """After a fault in a step, libcosim can run the FMU again; a fault at the start ends the process."""
    variables = {v.name: v for v in fmpy.read_model_description(fmi2["rod_drop"]).modelVariables}
    reference = str(variables["contact.restitution"].valueReference)
    command = [sys.executable, "-c", PROGRAM, fmi2["rod_drop"], reference, when]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    sentence = "fmi2SetReal: contact.restitution = 2.0 must be a finite number >= 0 and <= 1"
    assert sentence in process.stdout + process.stderr
    if when == "run":
        assert process.returncode == 0, process.stderr[-2000:]
        assert "\nlives on\n" in process.stdout
