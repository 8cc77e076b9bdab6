"""The belt: it runs at a constant speed along +x; the first tenth of a second presses it against the tip.

``python models/stick_slip_belt/motion.py FILE`` simulates, and draws the motion into a file.
"""

import math
import sys
from pathlib import Path

SPEED, LIFT = 0.02, 0.011  # m/s, m


def height(time):
    """The displacement of the belt [m]."""
    return LIFT * (1.0 - math.exp(-((50.0 * time) ** 2)))


INPUTS = {"wall.y_min.belt_speed": SPEED, "wall.y_min.displacement": height}

if __name__ == "__main__":
    from chain_impact import load_scene, simulate

    simulate(load_scene(Path(__file__).parent), inputs=INPUTS).plot(sys.argv[1])
