"""A rod whose tip comes near a wall above it, in motions in closed form."""

import math

import numpy as np

from chain_impact.kernel.status import OK
from chain_impact.simulation.instance import Instance
from tests.helpers.scenes.problems import build, contact_table

FAR = 100.0  # m, a wall out of reach


def instance(law):
    """Return an instance of a free rod with a contact law, whose tip may touch a wall above it."""
    table = contact_table(points=[1], model=law)
    start = {"position": [0.0, 0.0], "angles": [0.5]}
    return Instance(build("Graze", [{"length": 1.0, "mass": 1.0}], start, {"y_max": FAR}, table))


def set_motion(record, random, motion):
    """Put a random rod and its motion, thrown or spinning, into a record.

    Return the time [s] at which its tip is highest, and this height [m].
    """
    length, speed = random.uniform(0.3, 2.0), random.uniform(1.0, 9.0)
    gravity, spin = (random.uniform(1.0, 20.0), 0.0) if motion == "thrown" else (0.0, speed)
    angle, drift = random.uniform(-1.4, 1.2), random.uniform(-3.0, 3.0)
    middle = 0.5 * length * np.array([math.cos(angle), math.sin(angle)])
    if motion == "thrown":
        # without rotation the tip follows a parabola
        velocity, top = [drift, speed], speed / gravity
        height = length * math.sin(angle) + 0.5 * speed * top
    else:
        # the rod rotates about its middle, which moves along the wall
        velocity, top = [drift + spin * middle[1], -spin * middle[0]], (0.5 * math.pi - angle) / spin
        height = middle[1] + 0.5 * length
    mass = random.uniform(0.1, 3.0)
    record["chain"]["gravity"] = 0.0, -gravity
    record["chain"]["length"], record["chain"]["mass"] = length, mass
    record["initial"]["velocity"], record["initial"]["angular_velocity"] = velocity, spin
    record["initial"]["angle"] = angle
    record["solver"]["tolerance"] = 10.0 ** random.uniform(-12.0, -3.0)
    return top, height


def run(rod, wall, time):
    """Run to a time [s] with the wall at a height [m]; return the tip's height [m] and its number of hits."""
    rod.record["chain"]["box_wall"][3] = wall
    rod.initialize()
    assert rod.advance(time) == OK
    rod.observe()
    return float(rod.record["output"]["point_position"][1, 1]), int(rod.record["impact"]["count"])
