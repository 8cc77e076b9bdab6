"""The energy check of a step: the energy balance shows errors that the error estimate does not detect.

The exact motion conserves the energy balance (model/energy.py), so any change of it in a step is an error.
Errors of the tolerance in speeds can change an energy E by the tolerance times √(2E) (√(2E) + √E₁), where E₁
is twice that of the stretched chain when it moves by the longest link s and rotates by 1 rad per second. So
all steps from the start to the time t may together add or take

    B = 3 tolerance (√(2E) (√(2E) + √E₁) + M g (s + Σ L_i) + E₂) (1 + t / 10 s),

with E₂ = M s² per second squared, M the mass, and E the energy available to motion, springs, walls and heat:
the energy balance at the start less the potential energy, plus the supplied energy. What they add may not be
more than a tenth of E either.

A step is rejected if it changes the balance by more than both the part of B that is left and the growth of B
in this step. The ratio of its change to this limit acts on the size of the next step like an error relative
to the tolerance.
"""

import math

from chain_impact.kernel.chain.joints import spring_stiffness, stretch
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import ANGLES, dissipated_at, supplied_at
from chain_impact.kernel.integration.control import FAR_OFF, accepted, refuse
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.errors import impact_energy
from chain_impact.kernel.integration.last_step import (
    SOLVER,
    ensure_dense,
    ensure_points,
    ensure_rate,
    largest_turn,
)
from chain_impact.kernel.integration.method import EXPLICIT
from chain_impact.kernel.integration.switching import STABLE, joints_over
from chain_impact.kernel.model.contact_force import elastic_force
from chain_impact.kernel.model.energy import energy_balance, mechanical_energy, other_energy
from chain_impact.kernel.model.geometry import clearance, coordinates_size
from chain_impact.kernel.status import ENERGY_NOT_KEPT, OK

# The change allowed to the errors of all steps over the tolerance, and in how many seconds it is so again.
# In 3360 random scenes this limits steps in 3 % of the runs, most of them with stiff springs.
ALLOWED, LASTING = 3.0, 10.0
GAIN = 0.1  # of the available energy: what the errors of all steps together may add
NOTABLE = 0.1  # of the change allowed to a step: a smaller one has no effect on the size of the next step
# A tolerance above which the first step of a run, whose size is a guess, can be as long as half a turn of a
# link, with a correct end by chance.
LOOSE = 1e-4
# Rotation of a link in a step [rad] beyond which the dense output, if the step has one, is checked.
LONG_TURN = 1.0
INTERPOLATED = 10.0  # times the allowed change of a step: allowed at its middle, where the order is lower
ROUND_OFF = 1e-15  # of the energies, and of each force times the coordinates of its point, in a step


def start_balance(d, time):
    """Begin the balance of a run at ``time`` [s]."""
    model, balance = d.model, d.balance
    total, reach, square = 0.0, model.size, 0.0
    for i in range(d.links):
        total += model.mass[i]
        reach += model.length[i]
        # ½ m (s + Σ L)² + ½ I, twice, of the stretched chain
        square += model.mass[i] * reach * reach + model.inertia[i]
    balance.unit_motion = math.sqrt(square)
    balance.weight = total * model.gravity_size
    balance.unit_scale = balance.weight * reach + model.energy
    balance.since = time
    rebase_energy(d)
    balance.at_start, balance.origin = balance.at_end, balance.at_end
    _, potential = mechanical_energy(d, d.step.state_end)
    balance.available = ALLOWED * d.solver.tolerance * (square + balance.unit_scale)
    balance.available = most_energy(d, d.step.state_end, potential)
    balance.available_at_start = balance.available


def rebase_energy(d):
    """Evaluate the energy balance at the start of a step that does not continue the last one."""
    locate_points(d, d.step.state_end)
    d.balance.at_end = energy_balance(d, d.step.state_end)
    d.balance.breaks = d.step.breaks


def reinit_balance(d):
    """Re-initialize at the communication point, where a parameter may have changed the contacts' energy."""
    balance, before = d.balance, d.balance.at_start
    balance.available = balance.available_at_start
    if d.touch.active_count > 0:
        rebase_energy(d)
        balance.origin += balance.at_end - before
        balance.at_start = balance.at_end


def check_energy(d, theta):
    """Refuse the last step if it does not keep the energy balance, up to an event at θ or (−1) to its end.

    Its change over the allowed change, if it is notable, counts as an error of the step.
    """
    balance, y = d.balance, d.step.state_end
    if theta >= 0.0:
        y = d.work.y
        interpolate(d.step, theta, y)
        locate_points(d, y)
    else:
        ensure_rate(d)
        ensure_points(d)
    kinetic, potential = mechanical_energy(d, y)
    present = kinetic + potential + other_energy(d, y)
    change, there = present - balance.at_end, most_energy(d, y, potential)
    share = abs(change) / change_allowed(d, there, change > 0.0)
    if not math.isfinite(share):
        refuse(d, FAR_OFF)
        return
    if share > 1.0 and abs(change) <= round_off(d, y, kinetic + abs(potential)):
        share = 1.0
    if share > NOTABLE:
        refuse(d, share)
    if accepted(d) and d.step.rate_known and is_long(d) and not interpolates(d):
        refuse(d, FAR_OFF)
    if accepted(d):
        balance.at_start, balance.available_at_start = balance.at_end, balance.available
        balance.at_end, balance.available = present, there


def most_energy(d, y, potential):
    """The available energy [J] up to and in state y, where the potential energy is ``potential``."""
    return max(d.balance.available, d.balance.origin - potential + max(0.0, y[supplied_at(d.links)]))


def change_allowed(d, there, gains):
    """By how much the last step may change the energy balance [J], > 0; ``gains``: whether it adds energy."""
    balance, most = d.balance, budget(d, there)
    if gains:
        most = min(most, GAIN * there)
    drift = balance.at_end - balance.origin
    left = most - drift if gains else most + drift
    share = (d.step.end - d.step.start) / (LASTING + d.step.end - balance.since)
    return max(left, share * most, ROUND_OFF * there)


def budget(d, there):
    """B at the end of the last step [J], where the available energy is ``there``."""
    balance, speed = d.balance, math.sqrt(2.0 * there)
    most = ALLOWED * d.solver.tolerance * (speed * (speed + balance.unit_motion) + balance.unit_scale)
    return most * (1.0 + (d.step.end - balance.since) / LASTING)


def is_long(d):
    """Whether the last step is so long that its end may be correct by chance, and wrong in between.

    That is a step in which a link has turned far, if the dense output is available to check; an explicit one
    that is longer than its stability limit for joints with dampers or springs; and, at a loose tolerance, the
    first one of a run, whose size is a guess.
    """
    if d.statistics.steps == 0 and d.solver.tolerance > LOOSE:
        return True
    if d.step.dense_for == SOLVER and largest_turn(d) > LONG_TURN:
        return True
    resisted = d.model.resisting and d.step.last_method == EXPLICIT
    return resisted and joints_over(d, d.step.end - d.step.start) > STABLE


def interpolates(d):
    """Whether the dense output keeps the energy balance and dissipation in the middle of the last step."""
    y, at = d.work.y, dissipated_at(d.links)
    ensure_dense(d, SOLVER)
    interpolate(d.step, 0.5, y)
    start, end = d.step.state[at], d.step.state_end[at]
    # the scale of its errors, as in errors.py
    slack = INTERPOLATED * ALLOWED * d.solver.tolerance * (d.model.energy + abs(end) + impact_energy(d))
    if not min(start, end) - slack <= y[at] <= max(start, end) + slack:
        return False
    locate_points(d, y)
    return abs(energy_balance(d, y) - d.balance.at_end) <= INTERPOLATED * budget(d, d.balance.available)


def round_off(d, y, mechanical):
    """The round-off [J] of the energy balance in state y, for the located points.

    ``mechanical``: kinetic energy and the absolute value of the potential one [J], which is a difference of
    much larger terms far from the origin. So are the stretch of a spring and the depth of a contact.
    """
    known = mechanical + abs(y[dissipated_at(d.links)]) + abs(y[supplied_at(d.links)])
    known += d.balance.weight * (abs(y[0]) + abs(y[1]))
    for i in range(d.links if d.model.sprung else 0):
        moment = spring_stiffness(d, i) * abs(stretch(d, y, i))
        known += moment * (abs(y[ANGLES + i]) + abs(d.model.joint_rest_angle[i]))
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        gap, _ = clearance(d, c)
        known += elastic_force(d, c, max(0.0, -gap)) * coordinates_size(d, c, y)
    return ROUND_OFF * known


def check_balance(d):
    """ENERGY_NOT_KEPT if all steps have added or taken a fifth of the energy, and more than 2 B, or OK."""
    balance, most = d.balance, GAIN * d.balance.available
    gain = balance.at_end - balance.origin
    kept = -2.0 * max(most, budget(d, balance.available)) <= gain <= 2.0 * most
    return OK if kept else ENERGY_NOT_KEPT
