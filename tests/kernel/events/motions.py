"""Steps near walls with motions in closed form, and their first crossings by dense sampling."""

import numpy as np
from scipy.optimize import brentq

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events import crossing
from chain_impact.kernel.events.event_exclusion import begin_next_interval, suspect_all_candidates
from chain_impact.kernel.forces.active_contacts import latch_onset, set_kink_sides
from tests.helpers.scenes.problems import of_law
from tests.kernel.chains import chain, mark_touching
from tests.kernel.steps import free_motion, gaps_of, set_step, translation, wall_at, walls_away

SAMPLES = np.linspace(0.0, 1.0, 2001)


def moving(seed, *, count=2, size=0.4, near=3, touching=0, base="free"):
    """Return a step near some walls with some candidates in contact, prepared for ``find_event``."""
    rng = np.random.default_rng(seed)
    _, d = chain(rng, count, base)
    motion = free_motion(rng, d)
    walls_away(d)
    set_step(d, motion, size, start=rng.uniform(0.0, 3.0))
    chosen = rng.choice(d.candidate_count, near + touching, replace=False)
    for c in chosen[:near]:
        wall_at(d, c, motion.at(0.0), rng.uniform(0.05, 0.5))
    for c in chosen[near:]:
        wall_at(d, c, motion.at(0.0), -rng.uniform(0.05, 0.5))
    mark_touching(d, chosen[near:])
    prepare(d)
    return d, motion


def prepare(d):
    suspect_all_candidates(d)
    crossing.measure_clearances(d, 0.0)
    begin_next_interval(d)
    crossing.bound_curvature(d)


def phi(d, motion, theta):
    """Return φ of all candidates at fractions of the step: clearances, and penetrations of contacts."""
    states = motion.at(np.atleast_1d(theta) * d.step.size).T
    return gaps_of(d, states) * np.where(d.contacts.active == 1, -1.0, 1.0)


def first_fall(d, motion):
    """Return the first θ at which some φ falls through zero, and its candidate, by samples and brentq."""
    values, best = phi(d, motion, SAMPLES), (-1.0, -1)
    for c in range(d.candidate_count):
        falls = np.flatnonzero((values[:-1, c] > 0.0) & (values[1:, c] <= 0.0))
        if len(falls):
            low, high = SAMPLES[falls[0]], SAMPLES[falls[0] + 1]
            theta = brentq(lambda t, c=c: phi(d, motion, t)[0, c], low, high, xtol=1e-15)
            if best[0] < 0.0 or theta < best[0]:
                best = (theta, c)
    return best


FLOOR = 2  # the number of the wall y_min
DEEP = 0.3  # m, at the start


def falling(height, law="jankowski", size=1.0, touching=(1,)):
    """Return a chain in contact that moves to and from the floor without rotation, and its motion.

    The depths are δ = DEEP − height(t); ``height`` is a polynomial, lowest power first.
    """
    _, d = chain(np.random.default_rng(0), 2, **of_law(law), stiffness=4.0, restitution=0.5)
    motion = translation(d, [0.3, 0.1], height)
    walls_away(d)
    assert all(d.candidate.wall[c] == FLOOR for c in touching)
    for c in touching:
        wall_at(d, c, motion.at(0.0), -DEEP)
    locate_points(d, motion.at(0.0))
    mark_touching(d, touching)
    for c in touching:
        latch_onset(d, c)
    d.contacts.kink_margin[:] = 0.0
    set_kink_sides(d)
    set_step(d, motion, size, start=2.0)
    return d, motion
