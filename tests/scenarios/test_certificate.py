"""Certificates of single steps: the bound holds, and every proven statement about an event is true."""

import math

import numpy as np
import pytest
from flint import arb
from scipy.integrate import solve_ivp

from benchmarks.certificate import NO_EVENT, ONE_EVENT, UNDECIDED, Step, certify
from chain_impact import load_scene
from chain_impact.kernel.status import OK
from chain_impact.simulation.instance import Instance
from tests.scenarios.grazes import FAR, instance, run, set_motion

pytestmark = pytest.mark.full("takes long, and needs python-flint")

FIRST = 60  # steps of a run


def steps(scene):
    """Yield the first steps of a run."""
    instance = Instance(scene)
    for _ in range(FIRST):
        if not instance.record["step"]["end"] < scene.simulation.stop_time:
            return
        assert instance.advance(np.nextafter(instance.record["step"]["end"], np.inf)) == OK
        yield Step(instance.record)


def at(step, x):
    """Return the variables of the step's polynomial at a place x of the step."""
    return np.array([float(series[0].mid()) for series in step.course(arb(x), 0)[0]])


def solution(step, x):
    """Return the values of an accurate solution from the start of the step."""
    rate = lambda _x, z: step.size * step.rate(z)  # noqa: E731
    return solve_ivp(rate, (0.0, x), at(step, 0.0), "DOP853", rtol=1e-12, atol=1e-15).y[:, -1]


@pytest.mark.parametrize("name", ["four_link_box", "pinned_arm", "rod_drop"])
def test_steps_are_proven_and_the_bound_holds(name):
    looked = 0
    for step in list(steps(load_scene(name)))[::6]:
        verdicts, bound_of_step = certify(step)
        expected = [ONE_EVENT if c in step.marked else NO_EVENT for c in range(len(verdicts))]
        assert verdicts == expected
        bound = bound_of_step.error * bound_of_step.reach
        for x in (0.3 * step.kept, 0.7 * step.kept, step.kept):
            error = np.abs(at(step, x) - solution(step, x))
            assert (error <= bound + 1e-12 * np.abs(at(step, x)) + 1e-15).all()
        looked += 1
    assert looked >= 5


def test_a_contact_that_a_step_misses_is_never_proven_away():
    missed = 0
    for step in steps(load_scene("four_link_box")):
        if len(step.marked) != 1 or step.kept > 0.9:
            continue
        (c,) = step.marked
        step.kept, step.marked = 1.0, []
        assert certify(step)[0][c] != NO_EVENT
        # the polynomial is bent away from the wall, so that it violates the equations of motion
        _, _, nx, ny = step.candidates[c]
        for j, n in enumerate((nx, ny)):
            step.polynomials[j][2] += arb(n)
        assert certify(step)[0][c] != NO_EVENT
        missed += 1
    assert missed >= 2


def test_a_step_of_other_equations_is_not_proven():
    for change in ("gravity", "mass"):
        step = next(steps(load_scene("four_link_box")))
        if change == "gravity":
            step.gravity = [0.0, -9.0]
        else:
            step.masses[0][0] *= 1.01
        verdicts, bound_of_step = certify(step)
        assert isinstance(bound_of_step, str) or bound_of_step.error > 1e-3, verdicts


@pytest.mark.parametrize("motion", ["thrown", "spinning"])
def test_a_graze_is_never_proven_away(motion):
    random, decided = np.random.default_rng(5), 0
    rod = instance("hertz")
    for _ in range(30):
        top, height = set_motion(rod.record, random, motion)
        rod.record["chain"]["box_wall"][3] = FAR
        depth = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-14.0, -1.0)
        # the steps below are those of a run without contact, which has this error
        error = abs(run(rod, FAR, top)[0] - height)
        rod.record["chain"]["box_wall"][3] = FAR
        rod.initialize()
        verdicts = set()
        while rod.record["step"]["end"] < 1.2 * top:
            assert rod.advance(np.nextafter(rod.record["step"]["end"], np.inf)) == OK
            step = Step(rod.record)
            step.offsets = [arb(float(depth)) - float(height)]
            verdicts.add(certify(step)[0][0])
        if depth > error:
            assert verdicts != {NO_EVENT}
        if -depth > error:
            assert ONE_EVENT not in verdicts
        decided += verdicts in ({NO_EVENT}, {NO_EVENT, ONE_EVENT}, {ONE_EVENT})
    assert decided >= 12


def test_a_wall_between_the_polynomial_and_the_solution_is_undecided():
    random, looked, rod = np.random.default_rng(6), 0, instance("hertz")
    for _ in range(60):
        set_motion(rod.record, random, "spinning")
        half = 0.5 * float(rod.record["chain"]["length"][0])
        rod.record["chain"]["box_wall"][3] = FAR
        rod.record["solver"]["tolerance"] = 10.0 ** random.uniform(-5.0, -3.0)
        rod.initialize()
        step = None
        while step is None or at(step, step.kept)[2] < 0.5 * math.pi:
            assert rod.advance(np.nextafter(rod.record["step"]["end"], np.inf)) == OK
            step = Step(rod.record)
        # the middle moves along the wall, and the rod rotates at a constant rate
        start = at(step, 0.0)
        x = (0.5 * math.pi - start[2]) / (start[5] * step.size)
        highest = start[1] + half
        near = (at(step, x + part * 1e-3 * step.kept) for part in np.linspace(-1.0, 1.0, 41))
        top = max(z[1] + half * math.sin(z[2]) for z in near)
        if 0.1 < x / step.kept < 0.9 and abs(top - highest) > 1e-10:
            step.offsets = [arb(-0.5 * (top + highest))]
            assert certify(step)[0] == [UNDECIDED]
            looked += 1
        if looked == 5:
            return
    pytest.fail(f"{looked} walls of 60 were between the polynomial and the solution")
