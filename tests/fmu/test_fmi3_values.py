"""FMI 3.0: the time in every state, and arrays as an importer sees them."""

import numpy as np

from tests.fmu.interface3 import PHASES, Component, Library

# The functions before each test run in the clean process.


def times(fmu, phases):
    library, found = Library(fmu), {}
    for phase in phases:
        one = Component(library).bring_to(phase)
        found[phase] = one.get("time")
    one = Component(library)
    one.enter(start=2.5)
    found["a later start"] = one.get("time")
    return found


def test_the_time_can_be_read_in_every_state(fmi3, run3):
    found = run3(times, fmi3["pinned_arm"], sorted(PHASES))
    assert all(isinstance(values, list) for values in found.values()), found
    assert found["instantiated"] == found["initialization mode"] == found["event mode"] == [0.0]
    assert found["a later start"] == [2.5]


def arrays(fmu, scalars):
    import fmpy

    names = [f"point.{quantity}" for quantity in ("position", "velocity", "acceleration")]
    flat = [name for row in scalars for name in row]
    rows = fmpy.simulate_fmu(fmu, output=[*names, *flat], stop_time=0.3, output_interval=0.01)
    return [[rows[name].tolist() for name in names], [[rows[n].tolist() for n in row] for row in scalars]]


def test_an_importer_finds_the_scalars_in_the_arrays(fmi3, clean):
    axes = (("x", "y"), ("vx", "vy"), ("ax", "ay"))
    scalars = [[f"point[{k}].{name}" for k in range(5) for name in names] for names in axes]
    found, expected = clean(arrays, fmi3["four_link_box"], scalars)
    found = np.array(found)
    assert found.shape == (3, 31, 5, 2)
    assert (found.reshape(3, 31, 10) == np.moveaxis(expected, 1, 2)).all()
    assert np.ptp(found, axis=1).min() > 0.0
