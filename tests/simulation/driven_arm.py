"""The pinned arm with inputs over time, and its motion by the assembled equations."""

import itertools
import math

import numpy as np
from scipy.integrate import solve_ivp

from chain_impact import load_scene
from chain_impact.scene.scene import with_values
from tests.helpers.models.reference import generalized_force, mass_matrix

STOP = 0.4  # s, before the first impact
SHOULDER, ELBOW = "joint[1].torque", "joint[2].torque"


def wave(time):
    """Return a torque [N·m] that is smooth in time [s]."""
    return 3.0 * math.sin(9.0 * time) + 1.0


def push(time):
    return 2.0 * math.cos(5.0 * time)


def arm(**inputs):
    """Return the pinned arm, its wall out of reach."""
    changes = {("box", "x_max"): 10.0, ("simulation", "stop_time"): STOP, ("solver", "tolerance"): 1e-11}
    scene = with_values(load_scene("pinned_arm"), changes)
    return with_values(scene, {("inputs", name): value for name, value in inputs.items()})


def reference_motion(scene, torques, tip_force, times, breaks=()):
    """Return angles and their rates, shape (T, 4), by the assembled equations of motion and scipy at 1e-12.

    Args:
        torques: function of t → torque of joints 1 and 2 [N·m].
        tip_force: function of t → force on the tip, shape (2,) [N].
        times: shape (T,) [s].
        breaks: times [s] at which an input is not smooth.
    """
    damping = np.array([link.joint_damping for link in scene.chain.links])

    def rate(time, y):
        angles, omega = y[:2], y[2:]
        joint = np.asarray(torques(time)) - damping * np.diff(omega, prepend=0.0)
        loads = np.zeros((3, 2))
        loads[2] = tip_force(time)
        force = generalized_force(scene, angles, omega, loads, joint - np.append(joint[1:], 0.0))
        return np.concatenate([omega, np.linalg.solve(mass_matrix(scene, angles)[2:, 2:], force[2:])])

    y = np.array([*scene.initial.angles, *scene.initial.angular_velocities])
    rows, edges = [y], [times[0], *breaks, times[-1]]
    for start, end in itertools.pairwise(edges):
        times_of_piece = times[(times > start) & (times <= end)]
        # the ends of a piece are left out, because a step signal changes there
        first, last = start + 1e-12 * (end - start), end - 1e-12 * (end - start)
        solution = solve_ivp(
            lambda t, y, first=first, last=last: rate(min(max(t, first), last), y),
            (start, end),
            y,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            dense_output=True,
        )
        rows.extend(solution.sol(times_of_piece).T)
        y = solution.y[:, -1]
    return np.array(rows)


def motion(result):
    return np.hstack([result.angles, result.angular_velocities])
