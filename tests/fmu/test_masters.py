"""An FMU for FMI 2.0 in each of the masters of controlled_arm; and a value that it refuses, in libcosim.

libcosim is a master in C++ that calls FMUs from threads of its own.
"""

import json
import subprocess
import sys

import fmpy
import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.scene.models import models_folder
from chain_impact.variables.model import Model
from tests.tiers import needs_interop

RUN = """
import json, sys
import numpy as np

folder, fmu, master, count, step = sys.argv[1:]
sys.path.insert(0, folder)
from masters import MASTERS

outputs = MASTERS[master]([fmu], np.arange(int(count) + 1) * float(step))
print(json.dumps({name: values.tolist() for name, values in outputs.items()}))
"""


@pytest.mark.full("takes long")
@pytest.mark.parametrize("master", ["fmpy", "libcosim", "ecos"])
def test_every_master_runs_one_fmu_to_what_simulate_gives(native, master):
    """Their communication points differ by round-off, which the chain's impacts amplify 2e4 times."""
    scene = load_scene("four_link_box")
    result = simulate(scene)
    step = scene.simulation.step_size
    done = subprocess.run(
        [
            *(sys.executable, "-c", RUN, models_folder() / "controlled_arm", native["four_link_box"], master),
            *map(str, (len(result.time) - 1, step)),
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(done.stdout.splitlines()[-1])
    for name, expected in Model(scene).series(result.outputs).items():
        scale = np.abs(expected).max() + 1.0
        np.testing.assert_allclose(found[name], expected, rtol=0, atol=1e-8 * scale, err_msg=name)


# --- a value that is refused -----------------------------------------------------------------------------

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


@needs_interop
@pytest.mark.parametrize("when", ["start", "run"])
def test_libcosim_says_which_value_was_refused(fmi2, when):
    done = refused(fmi2["rod_drop"], when)
    sentence = "fmi2SetReal: contact.restitution = 2.0 must be a finite number >= 0 and <= 1"
    assert sentence in done.stdout + done.stderr


@needs_interop
def test_libcosim_lives_on_after_a_value_that_was_refused_during_the_run(fmi2):
    """And runs the FMU again; before the first step its threads catch no error, and it ends the process."""
    done = refused(fmi2["rod_drop"], "run")
    assert done.returncode == 0, done.stderr[-2000:]
    assert "\nlives on\n" in done.stdout
