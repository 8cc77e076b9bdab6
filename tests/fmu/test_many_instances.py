"""Many instances in a process: of several FMUs, in sequence and in threads; and in several processes."""

# Tests: fmu/build.py

import subprocess
import sys

import pytest

from chain_impact.fmu.build import build_fmu
from chain_impact.scene.scene import scene_from_dict
from tests.fmu.clean import importing
from tests.fmu.importer import CALLBACKS, Instance

FOREIGN = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Foreign(Fmi2Slave):
    """Integrates x' = -x by Euler's method."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x = 1.0
        self.register_variable(Real("x", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.x -= step_size * self.x
        return True
'''


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    """Return a minimal FMU of another project that uses pythonfmu."""
    folder = tmp_path_factory.mktemp("foreign")
    (folder / "foreign_slave.py").write_text(FOREIGN)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "foreign_slave.py"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return str(folder / "Foreign.fmu")


# Functions for ``clean``, and the test with importing(), run in the clean process with their own imports.


def in_turns(fmus, lots):
    """Run ``lots`` groups, each with an instance of each FMU, whose instances run in turns.

    Instance n of a group ends after 40 + 2 n steps, while later ones go on. Return outputs: group, FMU, step.
    """
    lives = []
    for _ in range(lots):
        instances, rows = [Instance(fmu).start() for fmu in fmus], [[] for _ in fmus]
        for k in range(60):
            for n, instance in enumerate(instances):
                if k < 40 + 2 * n:
                    rows[n] += instance.run([0.02 * (k + 1)])
                elif k == 40 + 2 * n:
                    instance.close()
        lives.append(rows)
    return lives


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("backwards", [False, True])
def test_fmus_of_all_kinds_and_a_foreign_one_do_not_mix(all_fmus, foreign, clean, backwards):
    """Each FMU gives the same digits as alone in its own process."""
    own_fmus = [all_fmus[target][model] for model in ("rod_drop", "four_link_box") for target in all_fmus]
    fmus = [*own_fmus[:2], foreign, *own_fmus[2:]]
    if backwards:
        fmus.reverse()
    first, second = clean(in_turns, fmus, 2)
    assert first == second
    for fmu, rows in zip(fmus, first, strict=True):
        ((rows_alone,),) = clean(in_turns, [fmu], 1)
        assert rows[:40] == rows_alone
        assert rows_alone[0] != rows_alone[-1]


def growth(fmu, warm_up, cycles):
    """Return the growth of the process [kB] for each time that an instance is made, run and freed."""
    import gc
    import resource
    from pathlib import Path

    def memory():
        gc.collect()
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
        return int(pages) * resource.getpagesize() / 1024

    instance = Instance(fmu)
    for k in range(warm_up + cycles):
        if k == warm_up:
            memory_before = memory()
        # the instance is freed while the binary stays loaded, as in common tools
        instance.fmu.fmi2FreeInstance(instance.fmu.component)
        instance.fmu.instantiate(callbacks=CALLBACKS, loggingOn=True)
        instance.start().step(0.01)
        instance.fmu.terminate()
    return (memory() - memory_before) / cycles


@pytest.mark.full("more cases", but="native")
def test_native_instances_leave_nothing_behind(strict, clean):
    assert clean(growth, strict["rod_drop"], 500, 4000) < 0.01  # kB


@pytest.mark.full("takes long")
def test_a_pythonfmu_instance_leaks_no_more_than_an_empty_slave(all_fmus, foreign, clean):
    """pythonfmu's wrapper executes the script for every instance, and never frees its code and names."""
    own_growth = clean(growth, all_fmus["pythonfmu"]["rod_drop"], 200, 1000)
    foreign_growth = clean(growth, foreign, 200, 1000)
    assert own_growth < foreign_growth + 1.0
    assert own_growth < 2.0  # kB; 49 kB would be left if the script contained the slave's class
    assert foreign_growth > 3.0  # a value above 3 shows that the measure detects leaks


@importing("rod_drop")
def test_instances_in_threads_give_what_they_give_one_by_one(fmu):
    """Four threads run the lives of three instances each; then the same instances run in sequence."""
    import sys
    from concurrent.futures import ThreadPoolExecutor

    sys.setswitchinterval(1e-5)
    first = Instance(fmu)  # the other instances use the same folder, and thus the same binary
    instances = [first, *(Instance(fmu, f"instance {n}", first.folder) for n in (1, 2, 3))]

    def lives(n):
        instance, rows = instances[n], []
        for _ in range(3):
            instance.fmu.fmi2FreeInstance(instance.fmu.component)
            instance.fmu.instantiate(callbacks=CALLBACKS, loggingOn=True)
            instance.start(**{"initial.y": 0.7 + 0.1 * n})
            rows.append(instance.run([0.005 * (i + 1) for i in range(200)]))
        return rows

    with ThreadPoolExecutor(len(instances)) as pool:
        together = list(pool.map(lives, range(len(instances))))
    one_by_one = [lives(n) for n in range(len(instances))]
    assert together == one_by_one
    assert len({str(rows) for rows in one_by_one}) == len(instances)


# --- one scene in all kinds of FMU, and in several processes -----------------------------------------------


def whole_scene(fmu, stop, step):
    """Return all outputs at each step of a run without changed parameters, and the modules it imports."""
    import sys

    import fmpy

    fmpy.read_model_description(fmu)  # load the modules that fmpy imports late
    modules_before = set(sys.modules)
    instance = Instance(fmu).start()
    rows = instance.run([i * step for i in range(round(stop / step) + 1)])
    return [rows, sorted(set(sys.modules) - modules_before)]


def state_of(fmu, data=None):
    """Run steps of 10 ms to 0.6 s and return the saved state, or run from a saved state to 1.2 s."""
    instance = Instance(fmu)
    if data is None:
        instance.start()
        instance.run([0.01 * (i + 1) for i in range(60)])
        return instance.fmu.serializeFMUstate(instance.fmu.getFMUstate()).hex()
    instance.fmu.setFMUstate(instance.fmu.deSerializeFMUstate(bytes.fromhex(data)))
    instance.time = 0.01 * 60
    return instance.run([0.01 * (i + 1) for i in range(60, 120)])


def test_a_state_goes_on_in_another_process(native, clean):
    restored = clean(state_of, native["four_link_box"], clean(state_of, native["four_link_box"]))
    rows, _ = clean(whole_scene, native["four_link_box"], 1.2, 0.01)
    assert restored == rows[61:]


@pytest.mark.full("takes long")
def test_a_long_chain(tmp_path, clean):
    """A chain of 12 links has the kernel for any number of links."""
    scene = {"name": "Long", "chain": {"links": [{"length": 0.2, "mass": 0.3}] * 12}, "box": {"y_min": 0.0}}
    scene["initial"] = {"position": [0.1, 0.3], "angles": [0.01 * i for i in range(12)]}
    scene = scene_from_dict(scene, "long")
    fmus = [str(build_fmu(scene, tmp_path / kind, target=kind)) for kind in ("native", "pythonfmu")]
    rows, rows_of_pythonfmu = (clean(whole_scene, fmu, 0.3, 1e-2)[0] for fmu in fmus)
    assert rows == rows_of_pythonfmu
    assert rows[0] != rows[-1]
