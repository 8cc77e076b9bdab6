"""The table: y = a sin ωt, with the acceleration a ω² = Γ g.

``python models/bouncing_table/motion.py FILE`` simulates, and draws the motion into a file.
"""

import math
import sys
from pathlib import Path

GRAVITY, FREQUENCY = 9.81, 2.0 * math.pi * 10.0  # m/s², rad/s
ACCELERATION = 1.3  # Γ


def inputs(acceleration=ACCELERATION):
    """The motion of the table with the largest acceleration Γ g."""
    amplitude = acceleration * GRAVITY / FREQUENCY**2
    return {"wall.y_min.displacement": lambda time: amplitude * math.sin(FREQUENCY * time)}


INPUTS = inputs()

if __name__ == "__main__":
    from chain_impact import load_scene, simulate

    simulate(load_scene(Path(__file__).parent), inputs=INPUTS).plot(sys.argv[1])
