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


# The functions without assertions run in the clean process, so they contain all their imports.


def in_turns(fmus, lots):
    """Run ``lots`` groups of instances, of which each has one of each FMU; those of a group run in turns.

    The other instances continue after the end of one. Return the rows of outputs by group and FMU.
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
    ours = [all_fmus[target][model] for model in ("rod_drop", "four_link_box") for target in all_fmus]
    fmus = [*ours[:2], foreign, *ours[2:]]
    if backwards:
        fmus.reverse()
    first, second = clean(in_turns, fmus, 2)
    assert first == second
    for fmu, rows in zip(fmus, first, strict=True):
        ((alone,),) = clean(in_turns, [fmu], 1)
        assert rows[:40] == alone
        assert alone[0] != alone[-1]


def growth(fmu, warm_up, cycles):
    """Return the growth of the process [kB] for each time that an instance is made, run and freed."""
    import gc
    import resource
    from pathlib import Path

    def memory():
        gc.collect()
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
        return int(pages) * resource.getpagesize() / 1024

    one = Instance(fmu)
    for k in range(warm_up + cycles):
        if k == warm_up:
            before = memory()
        # the instance is freed while the binary stays loaded, as in common tools
        one.fmu.fmi2FreeInstance(one.fmu.component)
        one.fmu.instantiate(callbacks=CALLBACKS, loggingOn=True)
        one.start().step(0.01)
        one.fmu.terminate()
    return (memory() - before) / cycles


@pytest.mark.full("more cases", but="native")
def test_native_instances_leave_nothing_behind(strict, clean):
    assert clean(growth, strict["rod_drop"], 500, 4000) < 0.01  # kB


@pytest.mark.full("takes long")
def test_a_pythonfmu_instance_leaks_no_more_than_an_empty_slave(all_fmus, foreign, clean):
    """pythonfmu's wrapper executes the script for every instance and never frees its code and names."""
    ours = clean(growth, all_fmus["pythonfmu"]["rod_drop"], 200, 1000)
    empty = clean(growth, foreign, 200, 1000)
    assert ours < empty + 1.0
    assert ours < 2.0  # kB; 49 kB would be left if the script contained the slave's class
    assert empty > 3.0  # a value above 3 shows that the measure detects leaks


@importing("rod_drop")
def test_instances_in_threads_give_what_they_give_one_by_one(fmu):
    """Four threads run the lives of three instances each; then the same instances run in sequence."""
    import sys
    from concurrent.futures import ThreadPoolExecutor

    sys.setswitchinterval(1e-5)
    first = Instance(fmu)  # the other instances use the same folder, and thus the same binary
    instances = [first, *(Instance(fmu, f"instance {n}", first.folder) for n in (1, 2, 3))]

    def lives(n):
        one, rows = instances[n], []
        for _ in range(3):
            one.fmu.fmi2FreeInstance(one.fmu.component)
            one.fmu.instantiate(callbacks=CALLBACKS, loggingOn=True)
            one.start(**{"initial.y": 0.7 + 0.1 * n})
            rows.append(one.run([0.005 * (i + 1) for i in range(200)]))
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
    before = set(sys.modules)
    instance = Instance(fmu).start()
    rows = instance.run([i * step for i in range(round(stop / step) + 1)])
    return [rows, sorted(set(sys.modules) - before)]


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
    """Run the kernel for any number of links."""
    scene = {"name": "Long", "chain": {"links": [{"length": 0.2, "mass": 0.3}] * 12}, "box": {"y_min": 0.0}}
    scene["initial"] = {"position": [0.1, 0.3], "angles": [0.01 * i for i in range(12)]}
    scene = scene_from_dict(scene, "long")
    fmus = [str(build_fmu(scene, tmp_path / kind, target=kind)) for kind in ("native", "pythonfmu")]
    rows, others = (clean(whole_scene, fmu, 0.3, 1e-2)[0] for fmu in fmus)
    assert rows == others
    assert rows[0] != rows[-1]
