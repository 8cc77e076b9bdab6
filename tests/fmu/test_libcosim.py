"""A value that the FMU refuses, in libcosim: a master in C++ that calls FMUs from threads of its own."""

import subprocess
import sys

import fmpy
import pytest

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


def refused(fmu, when):
    """What a process says that sets the restitution to 2, before the first step or during the run."""
    variables = {v.name: v for v in fmpy.read_model_description(fmu).modelVariables}
    reference = variables["contact.restitution"].valueReference
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, fmu, str(reference), when],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("when", ["start", "run"])
def test_libcosim_says_which_value_was_refused(fmus, when):
    done = refused(fmus["rod_drop"], when)
    sentence = "fmi2SetReal: contact.restitution = 2.0 must be a finite number >= 0 and <= 1"
    assert sentence in done.stdout + done.stderr


def test_libcosim_lives_on_after_a_value_that_was_refused_during_the_run(fmus):
    """And runs the FMU again; before the first step its threads catch no error, and it ends the process."""
    done = refused(fmus["rod_drop"], "run")
    assert done.returncode == 0, done.stderr[-2000:]
    assert "\nlives on\n" in done.stdout
