"""Models with moving bases, walls or belts, in a few lines each, which share no code with the kernel."""

import math
from itertools import cycle

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.helpers.scenes.problems import GRAVITY

ACCURATE = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}


def pendulum(times, start, amplitude, frequency, length):
    """Return angles [rad] from +x, and rates, of a rod on a pivot at y = a sin ωt; shape (2, T).

    ``start`` is the first angle and rate.
    """
    reduced = 2.0 * length / 3.0

    def rate(time, y):
        # l θ¨ = −(g + ÿ) cos θ
        lift = -amplitude * frequency**2 * math.sin(frequency * time)
        return [y[1], -(GRAVITY + lift) * math.cos(y[0]) / reduced]

    return solve_ivp(rate, (0.0, times[-1]), start, t_eval=times, max_step=0.2 / frequency, **ACCURATE).y


def stability(amplitude, frequency, reduced):
    """Return whether the upright pendulum of a reduced length is stable on a pivot at y = a sin ωt.

    By Floquet's theorem for the linear equation.
    """

    def rate(time, y):
        factor = (GRAVITY - amplitude * frequency**2 * math.sin(frequency * time)) / reduced
        return [y[1], factor * y[0], y[3], factor * y[2]]

    period = 2.0 * math.pi / frequency
    end = solve_ivp(rate, (0.0, period), [1.0, 0.0, 0.0, 1.0], **ACCURATE).y[:, -1]
    return abs(end[0] + end[3]) < 2.0


def table_impacts(start, amplitude, frequency, restitution, count):
    """Return the first ``count`` impact times [s] of a ball on a table at y = a sin ωt.

    ``start`` is the ball's height [m] and upward speed [m/s] at time 0.
    """
    time, times, (height, speed) = 0.0, [], start
    while len(times) < count:

        def gap(s, time=time, height=height, speed=speed):
            return height + s * (speed - 0.5 * GRAVITY * s) - amplitude * math.sin(frequency * (time + s))

        after = 1e-6
        while gap(after + 1e-4) > 0.0:
            after += 1e-4
        flight = brentq(gap, after, after + 1e-4, xtol=1e-17, rtol=1e-15)
        time += flight
        table = amplitude * frequency * math.cos(frequency * time)
        height = amplitude * math.sin(frequency * time)
        # v⁺ − w = −e (v⁻ − w)
        speed = table - restitution * (speed - GRAVITY * flight - table)
        times.append(time)
    return np.array(times)


def period_one(acceleration, frequency, restitution):
    """Return height [m] and speed [m/s] of a ball that bounces once a period, at the table's y = 0 upward.

    With Γ g the acceleration of the table (``acceleration`` is Γ), ball and table meet at the phase φ,
    cos φ = π (1 − e)/((1 + e) Γ).
    """
    amplitude = acceleration * GRAVITY / frequency**2
    phase = math.acos(math.pi * (1.0 - restitution) / ((1.0 + restitution) * acceleration))
    period = 2.0 * math.pi / frequency
    falling = 0.5 * period - phase / frequency  # [s] the time since the highest point
    top = amplitude * math.sin(phase) + GRAVITY * period**2 / 8.0
    return top - 0.5 * GRAVITY * falling**2, -GRAVITY * falling


def belt(stop_time, speed, height):
    """Return the motion of the link of ``stick_slip_belt``, as its angle from the vertical, on a belt.

    The belt runs at ``speed`` [m/s], and is lifted by ``height(time)`` [m].

    Returns:
        The solution of each phase as (start, end, function of time for the angle and, in slip, its rate), and
        the times of the changes of phases: slip, stick, slip …
    """
    inertia, stiffness, length, wall = 3.0 / 3.0, 2000.0, 1.0, 1000.0
    sliding, static = 0.2, 0.4

    def force(time, angle):
        return wall * max(0.0, length * math.cos(angle) - (1.001 - height(time)))

    def moment(time, angle, friction):
        # spring, normal force N along +y at (sin, −cos) L, friction along +x
        return (
            -stiffness * angle
            + force(time, angle) * length * math.sin(angle)
            + friction * length * math.cos(angle)
        )

    def stuck(_, y):
        # the tip moves with the belt: L cos θ θ˙ = v
        return [speed / (length * math.cos(y[0]))]

    def holding(time, y):
        # µ_s N − F, with F from I θ¨ = M + F L cos θ and θ¨ = θ˙² tan θ
        rate = speed / (length * math.cos(y[0]))
        needed = (inertia * rate**2 * math.tan(y[0]) - moment(time, y[0], 0.0)) / (length * math.cos(y[0]))
        return static * force(time, y[0]) - needed

    def slips(time, y):
        return [y[1], moment(time, y[0], sliding * force(time, y[0])) / inertia]

    def catches(_, y):
        return speed - length * math.cos(y[0]) * y[1]

    holding.terminal = catches.terminal = True
    holding.direction, catches.direction = -1.0, -1.0
    time, start, phases, changes = 0.0, [0.0, 0.0], [], []
    for phase in cycle((slips, stuck)):
        until = catches if phase is slips else holding
        run = solve_ivp(phase, (time, stop_time), start, events=until, dense_output=True, **ACCURATE)
        phases.append((time, run.t[-1], run.sol))
        time, angle = run.t[-1], run.y[0, -1]
        if time >= stop_time:
            return phases, np.array(changes)
        changes.append(time)
        start = [angle] if phase is slips else [angle, speed / (length * math.cos(angle))]
    return None


def belt_period(speed):
    """Return the period [s] of stick and slip for small angles: the belt's speed, then part of a cosine."""
    normal, mass = 10.0, 1.0
    stiffness = 2000.0 - normal  # N/m at the tip, L = 1 m: the normal force reduces the stiffness by N L
    frequency = math.sqrt(stiffness / mass)
    # m, from the place where slip begins to the equilibrium of sliding
    jump = (0.4 - 0.2) * normal / stiffness
    # the solution x = x_k + jump cos ωt + (v/ω) sin ωt, until its rate is v again
    slip = 2.0 * (math.pi - math.atan(jump * frequency / speed)) / frequency
    return slip + 2.0 * jump / speed


CARRIAGE, ARM = (20.0, 2000.0, 40.0), ((0.5, 2.0, 0.05), (0.4, 1.0, 0.05))
"""Mass, spring and damper of the carriage; length, mass and joint damping of each link of the arm."""


def carried(times, angles):
    """Return the carriage's place [m] and the arm's angles, from rest, as one system, shape (T, 3)."""
    mass, spring, damper = CARRIAGE

    def rate(_, y):
        turn, spin = y[1:3], y[4:6]
        inertia, forces = np.zeros((3, 3)), np.zeros(3)
        inertia[0, 0], forces[0] = mass, -spring * y[0] - damper * y[3]
        for i, (length, weight, _) in enumerate(ARM):
            # the centre of mass: J q¨ + J˙ q˙ with the rods before it, and half of its own rod
            reach = np.array([ARM[k][0] if k < i else 0.5 * length if k == i else 0.0 for k in range(2)])
            jacobian = np.zeros((2, 3))
            jacobian[0] = 1.0, *(-reach * np.sin(turn))
            jacobian[1] = 0.0, *(reach * np.cos(turn))
            drift = np.array([-(reach * np.cos(turn)) @ spin**2, -(reach * np.sin(turn)) @ spin**2])
            inertia += weight * jacobian.T @ jacobian
            inertia[i + 1, i + 1] += weight * length**2 / 12.0
            forces += weight * jacobian.T @ (np.array([0.0, -GRAVITY]) - drift)
        moments = [-ARM[0][2] * spin[0], -ARM[1][2] * (spin[1] - spin[0])]
        forces[1:] += [moments[0] - moments[1], moments[1]]
        return np.concatenate([y[3:], np.linalg.solve(inertia, forces)])

    start = [0.0, *angles, 0.0, 0.0, 0.0]
    return solve_ivp(rate, (0.0, times[-1]), start, t_eval=times, **ACCURATE).y[:3].T
