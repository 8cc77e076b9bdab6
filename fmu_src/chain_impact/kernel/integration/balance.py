"""The balance of energy over a step: the ledger shows what the error control cannot see.

The exact motion keeps the ledger of energies (model/energy.py), so what a step changes in it is error. Steps
that keep the tolerance change it by about the tolerance times a scale S, or less. To first order, with the
scales of errors.py for what the components of the state may err,

    S = (√(2T) + √E₁)² + M g (s + Σ L_i) + E₂ + Σ k |φ| + Σ (K δⁿ s_δ + ½ m v₀²)
        + dissipated and supplied energy,

where T is the kinetic energy, E₁ twice that of the stretched chain when it moves by the longest link s and
turns by 1 rad in a second, E₂ = M s² in a second squared, M the mass, k |φ| the moments of springs, over 1
rad, and s_δ, v₀ and m those of the active contacts. A step that changes much more is rejected: there is
something that its error estimate does not see, such as a motion that fades within its first stage. Nor must
the errors of all steps in a second of simulated time add up to much more.

S grows with an energy that comes from errors, and stiff springs make it far more than the energy itself. So
all steps since the start together must not bring more than a tenth of what motion, springs, walls and heat
can have by the start and the inputs: the ledger of the start less the potential energy, plus the supplied
energy. Once they have, only steps that bring no more are accepted.

Nor may they lose much. Errors of the tolerance in speeds take √(2E) (√(2E) + √E₁) times the tolerance of an
energy E. With what there can be as E, all steps from the start to the time t together may lose

    B = 3 tolerance (√(2E) (√(2E) + √E₁) + M g (s + Σ L_i) + E₂) (1 + t / 10 s).

A step that would lose more than is left of B is rejected, or more than B grows by in this step where that is
more. What it loses of that is to the size of the next step like an error relative to the tolerance.
"""

import math

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.springs import spring_stiffness, stretch
from chain_impact.kernel.chain.state import ANGLES, dissipated_at, supplied_at
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.errors import impact_energy, penetration_scale
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
from chain_impact.kernel.model.geometry import clearance
from chain_impact.kernel.status import ENERGY_NOT_KEPT, OK

# What a step may change in the ledger, over tolerance and S. In 1500 random scenes the largest change of a
# step was .0015 in the median, and more than 1 in 1 % of them.
OF_A_STEP = 3.0
# The same for all steps in a window. Errors of steps have no sign in common but where a point rests: then
# they add up to 230 in 100,000 steps. A run that goes beyond ends with a status.
OF_A_WINDOW = 100.0
WINDOW = 1.0  # s, as that of the work limit
GAIN = 0.1  # of the energy that there can be: what errors of all steps may bring
# Of the same: what a step may bring beyond that, so that round-off does not stop a run. When all of this adds
# up to another GAIN the run ends.
SLIP = 1e-8
# What errors of all steps may take at once, and again in how many seconds. In 3360 random scenes 3 % of the
# runs lose enough to feel it, most of them with stiff springs.
LOSS, LASTING = OF_A_STEP, 10.0
NOTABLE = 0.1  # of what is left of that: what a step may lose without an effect on the next one
# A tolerance above which the first step of a run, whose size is a guess, can be half a turn and right by
# chance.
LOOSE = 1e-4
# rad that a link turns in a step, beyond which its dense output is looked at where there is one.
LONG_TURN = 1.0
INTERPOLATED = 10.0  # times what a step may change, as the dense output has a lower order
ROUND_OFF = 1e-15  # of the energies, and of each force times the coordinates of its point, in a step


def start_balance(d, time):
    """Begin the first window at ``time`` [s]."""
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
    balance.start, balance.since, balance.loss = time, time, 0.0
    rebase_energy(d)
    balance.at_start, balance.origin = balance.at_end, balance.at_end
    begin_window(d)
    _, potential = mechanical_energy(d, d.step.state_end)
    balance.available = 0.0
    balance.available = most_energy(d, d.step.state_end, potential)


def begin_window(d):
    """Begin a window: the ledger is compared with what it is now."""
    balance = d.balance
    balance.reference = balance.at_end
    # what is allowed whatever the state
    balance.least_allowed = OF_A_STEP * d.solver.tolerance * (balance.unit_motion**2 + balance.unit_scale)
    balance.allowed = balance.least_allowed


def rebase_energy(d):
    """Note the ledger at the start of a step that does not go on where the last one ended."""
    locate_points(d, d.step.state_end)
    d.balance.at_end = energy_balance(d, d.step.state_end)
    d.balance.breaks = d.step.breaks


def reinit_balance(d):
    """Go on from the communication point, where a parameter may have changed the energy of the contacts."""
    if d.touch.active_count > 0:
        balance, before = d.balance, d.balance.at_start
        rebase_energy(d)
        balance.reference += balance.at_end - before
        balance.origin += balance.at_end - before


def energy_step_ok(d, theta):
    """Whether the last step keeps the ledger, up to the event at its fraction θ or, for −1, to its end.

    What it loses, over what it might, is noted as ``balance.loss``, more than 1 where that is the reason.
    """
    balance, y = d.balance, d.step.state_end
    balance.loss = 0.0
    if theta >= 0.0:
        y = d.work.y
        interpolate(d.step, theta, y)
        locate_points(d, y)
    else:
        ensure_rate(d)
        ensure_points(d)
    kinetic, potential = mechanical_energy(d, y)
    present = kinetic + potential + other_energy(d, y)
    change = present - balance.at_end
    # not >, in which a NaN would be lost
    if not abs(change) <= balance.least_allowed:
        allowed = allowance(d, y)
        if not abs(change) <= allowed:
            return False
        balance.allowed = max(balance.allowed, allowed)
    there = most_energy(d, y, potential)
    if change > SLIP * there and present - balance.origin > GAIN * there:
        return False
    loss = -change / loss_allowed(d, there)
    balance.loss = loss if loss > NOTABLE else 0.0
    if balance.loss > 1.0:
        if -change > round_off(d, y):
            return False
        balance.loss = 1.0
    if d.step.rate_known and is_long(d) and not interpolates(d):
        return False
    balance.at_start, balance.at_end, balance.available = balance.at_end, present, there
    return True


def most_energy(d, y, potential):
    """The most energy [J] that there could be so far and in state y, where gravity's is ``potential``."""
    balance, supplied = d.balance, y[supplied_at(d.links)]
    return max(balance.available, balance.least_allowed + balance.origin - potential + max(0.0, supplied))


def loss_allowed(d, there):
    """What the last step may lose [J], which is > 0."""
    balance, budget = d.balance, loss_budget(d, there)
    share = (d.step.end - d.step.start) / (LASTING + d.step.end - balance.since)
    left = budget - (balance.origin - balance.at_end)
    return max(left, share * budget, ROUND_OFF * there)


def loss_budget(d, there):
    """B at the end of the last step [J], where the most energy that there could be is ``there``."""
    balance, speed = d.balance, math.sqrt(2.0 * there)
    most = LOSS * d.solver.tolerance * (speed * (speed + balance.unit_motion) + balance.unit_scale)
    return most * (1.0 + (d.step.end - balance.since) / LASTING)


def is_long(d):
    """Whether the last step is so long that it may be right at its end by chance, and be wrong in between.

    That is a step in which a link has turned far, if there is a dense output to look at; an explicit one over
    which joints make more of a motion fade or swing than it is stable for; and, at a loose tolerance, the
    first one of a run, whose size is a guess.
    """
    if d.statistics.steps == 0 and d.solver.tolerance > LOOSE:
        return True
    if d.step.dense_for == SOLVER and largest_turn(d) > LONG_TURN:
        return True
    resisted = d.model.resisting and d.step.last_method == EXPLICIT
    return resisted and joints_over(d, d.step.end - d.step.start) > STABLE


def interpolates(d):
    """Whether the dense output keeps the ledger in the middle of the last step, and the energy dissipated."""
    y = d.work.y
    ensure_dense(d, SOLVER)
    interpolate(d.step, 0.5, y)
    if not dissipates_evenly(d, y[dissipated_at(d.links)]):
        return False
    locate_points(d, y)
    change = abs(energy_balance(d, y) - d.balance.at_end)
    return change <= INTERPOLATED * d.balance.least_allowed or change <= INTERPOLATED * allowance(d, y)


def dissipates_evenly(d, middle):
    """Whether the energy that is dissipated by the middle of the last step lies between that at its ends."""
    start, end = d.step.state[dissipated_at(d.links)], d.step.state_end[dissipated_at(d.links)]
    scale = d.model.energy + abs(end) + impact_energy(d)
    slack = INTERPOLATED * OF_A_STEP * d.solver.tolerance * scale
    return min(start, end) - slack <= middle <= max(start, end) + slack


def allowance(d, y):
    """What a step that ends in state y may change in the ledger [J], for the located points."""
    scale, known = scales(d, y)
    return OF_A_STEP * d.solver.tolerance * scale + ROUND_OFF * known


def round_off(d, y):
    """The part of it [J] that is round-off."""
    _, known = scales(d, y)
    return ROUND_OFF * known


def scales(d, y):
    """S, and the numbers [J] whose round-off is in the ledger, in state y with the points located."""
    kinetic, potential = mechanical_energy(d, y)
    # the potential energy is a difference of these
    known = d.balance.weight * (abs(y[0]) + abs(y[1])) + abs(potential)
    known += kinetic + abs(y[dissipated_at(d.links)]) + abs(y[supplied_at(d.links)])
    speed = math.sqrt(2.0 * kinetic) + d.balance.unit_motion
    scale = speed * speed + d.balance.unit_scale + impact_energy(d)
    scale += abs(y[dissipated_at(d.links)]) + abs(y[supplied_at(d.links)])
    if d.model.sprung:
        for i in range(d.links):
            moment = spring_stiffness(d, i) * abs(stretch(d, y, i))
            scale += moment
            known += moment * (abs(y[ANGLES + i]) + abs(d.model.joint_rest_angle[i]))
    if not d.contact.impulsive:
        for k in range(d.touch.active_count):
            c = d.touch.active_index[k]
            gap, _ = clearance(d, c)
            force, point = elastic_force(d.contact, max(0.0, -gap)), d.candidate.point[c]
            scale += force * penetration_scale(d, c)
            known += force * (abs(d.work.position.x[point]) + abs(d.work.position.y[point]))
    return scale, known


def check_balance(d):
    """ENERGY_NOT_KEPT when the steps of a window, or all, have changed the ledger by far too much, or OK."""
    balance, most = d.balance, GAIN * d.balance.available
    gain = balance.at_end - balance.origin
    if gain > 2.0 * most or -gain > 2.0 * max(most, loss_budget(d, balance.available)):
        return ENERGY_NOT_KEPT
    if d.step.end >= balance.start + WINDOW:
        balance.start = d.step.end
        begin_window(d)
    share, drift = OF_A_WINDOW / OF_A_STEP, abs(balance.at_end - balance.reference)
    if drift > share * balance.allowed:
        locate_points(d, d.step.state_end)
        balance.allowed = max(balance.allowed, allowance(d, d.step.state_end))
    return OK if drift <= share * balance.allowed else ENERGY_NOT_KEPT
