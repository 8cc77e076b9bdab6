"""The pivot of the pendulum: y = a sin ωt, with a²ω² above 2 g l_eff, so that the pendulum stands upright.

``python models/shaken_pendulum/motion.py FILE`` simulates, and draws the motion into a file.
"""

import math
import sys
from pathlib import Path

AMPLITUDE, FREQUENCY = 0.01, 2.0 * math.pi * 40.0  # m, rad/s


def height(time):
    """The height of the pivot [m]."""
    return AMPLITUDE * math.sin(FREQUENCY * time)


INPUTS = {"base.y": height}

if __name__ == "__main__":
    from chain_impact import load_scene, simulate

    simulate(load_scene(Path(__file__).parent), inputs=INPUTS).plot(sys.argv[1])
