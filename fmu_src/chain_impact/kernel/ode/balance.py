"""The energy check of a step: the energy balance shows errors that the error estimate does not detect.

The exact motion conserves the energy balance (equations.py), so any change of the balance in a step is an
error. The checks leave out `step.energy_added`, which corrections have added to the dissipated energy. If the
errors of the state in a step are within the tolerance, the balance changes by at most about the tolerance
times a scale S [J] (energy_scales.py).

A step that changes the balance by more than 3 × tolerance × S is rejected (STEP_CHANGE): its error estimate
misses something, such as a motion that decays within the first stage. The sum of the changes in one second of
simulated time has a limit, too (WINDOW_CHANGE); a run that exceeds this limit ends with a fault.

These limits alone are too weak: S grows with the energy that errors have added, and stiff springs make S far
larger than the energy of the chain. So all steps since the start together must not add more than a tenth of
the available energy, which is the most that motion, springs, walls and heat can have had so far. At each time
this is the energy balance at the start, less the potential energy, plus the supplied energy; the largest
value so far counts. If a tenth has been added, only steps that add almost no energy are accepted.

The energy that steps lose is limited as well. Errors of speeds as large as the tolerance can change an energy
E by the tolerance times √(2E) (√(2E) + √E₁). With the available energy for E, all steps within the time t
since the start may together lose

    B = 3 tolerance (√(2E) (√(2E) + √E₁) + M g (s + Σ L_i) + E₂) (1 + t / 10 s),

with the symbols of energy_scales.py.

The allowed loss of a step is the largest of three energies: the part of B that earlier steps have left, the
growth of B in this step, and round-off. A step that loses more than this, and more than round-off can cause,
is rejected. If a step loses more than a tenth of its allowed loss, this loss, divided by the allowed loss,
acts on the size of the next step like an error relative to the tolerance.
"""

import math

from chain_impact.kernel.chain.drives import (
    armature_of_drive,
)
from chain_impact.kernel.chain.inputs import apply_inputs
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.equations import energy_balance, mechanical_energy, other_energy
from chain_impact.kernel.ode.dense_output import interpolate_state
from chain_impact.kernel.ode.energy_scales import energy_scales
from chain_impact.kernel.ode.last_step import (
    count_supplied,
    ensure_dense,
    ensure_points,
    ensure_rate,
    largest_turn,
)
from chain_impact.kernel.ode.methods import STABLE_STEP, find_joint_stiffness
from chain_impact.kernel.ode.step_control import is_accepted, reject_step, set_outcome
from chain_impact.kernel.ode.step_errors import impact_energy
from chain_impact.kernel.record.constants import CHECK_FAILED, SOLVER_READER
from chain_impact.kernel.record.method import was_implicit
from chain_impact.kernel.record.state import dissipated_at, supplied_at
from chain_impact.kernel.status import ENERGY_NOT_KEPT, OK

# A step is rejected if it changes the energy balance, up or down, by more than STEP_CHANGE × tolerance × S
# plus round-off. In 1500 random scenes, the largest change of a run, relative to
# tolerance × S, had a median of 0.0015, and exceeded 1 in 1 % of the scenes.
STEP_CHANGE = 3.0
# A run ends with a fault if the energy balance changes in a window of time, up or down, by more than
# WINDOW_CHANGE × tolerance × S plus round-off. The errors of steps have a common sign only while a point
# rests on a wall: there the ratios of change to tolerance × S add up to 230 in 100,000 steps.
WINDOW_CHANGE = 100.0
# [s] the length of a window of time for WINDOW_CHANGE; equal to COST_WINDOW (cost.py)
BALANCE_WINDOW = 1.0
# The limit of the energy that the errors of all steps together add, relative to the available energy: the
# largest energy so far that motion, springs, walls and heat can have had. Beyond this limit, steps that add
# energy are rejected.
ENERGY_GAIN = 0.1
# The energy that a step may still add after ENERGY_GAIN has been reached, so that round-off does not stop the
# run; relative to the available energy, as ENERGY_GAIN is. If such additions reach ENERGY_GAIN again, the run
# ends.
SLIGHT_GAIN = 1e-8
# ENERGY_LOSS: the factor 3 in the allowed loss B above. LOSS_TIME: the time [s] in B after which twice the
# initial loss is allowed. In 3360 random scenes the limit B shortens steps in 3 % of the runs, most of them
# with stiff springs.
ENERGY_LOSS, LOSS_TIME = STEP_CHANGE, 10.0
# A loss above NOTABLE_LOSS times the loss that is allowed to a step counts as an error of the step, and so
# affects the next size; a smaller loss has no effect.
NOTABLE_LOSS = 0.1
# The tolerance above which the first step of a run is checked in its middle. The size of this step is a
# guess: at a loose tolerance a link may make half a turn in the step, which then has a correct end by chance.
LOOSE_TOLERANCE = 1e-4
# [rad] If a link turns more than LONG_TURN in a step whose dense output exists, the dense output is checked
# in the middle of the step.
LONG_TURN = 1.0
# the change of the energy balance that is allowed from the start to the middle of a step, where the dense
# output has a lower order, divided by the change that is allowed to the end
MIDDLE_CHANGE = 10.0
# The round-off of the energy balance in a step, relative to the sum of all energies and of the products of
# each contact force, spring force and weight with the coordinates at which this force acts. ENERGY_ROUND_OFF
# times the available energy is also the least value of ``loss_allowed``.
ENERGY_ROUND_OFF = 1e-15


def start_balance(d, time):
    """Begin the energy balance of a run at ``time`` [s].

    The function sets the scales, the first window of time and the available energy: the most [J] that motion,
    springs, walls and heat can have had so far.
    """
    chain, balance = d.chain, d.balance
    reach, carriage = chain.longest_link, d.slider.mass if d.slides else 0.0
    total, square = carriage, carriage * reach * reach
    for i in range(d.link_count):
        total += chain.mass[i]
        reach += chain.length[i]
        # E₁, twice the kinetic energy of carriage and stretched chain: m s² of the carriage, plus the sum of
        # m (s + Σ L)² + I over the links, with the longest link s, Σ L up to the end of the link, and the
        # armature's inertia in I
        square += chain.mass[i] * reach * reach + (chain.inertia[i] + armature_of_drive(d, i))
    balance.root_reference_energy = math.sqrt(square)
    balance.weight = total * chain.gravity_magnitude
    balance.reference_energy = balance.weight * reach + chain.energy_scale
    balance.window_start, balance.run_start = time, time
    evaluate_balance_at_end(d)
    balance.value_start, balance.run_value = balance.value_end, balance.value_end
    begin_window(d)
    _, potential = mechanical_energy(d, d.step.state_end)
    balance.available_energy = 0.0
    balance.available_energy = largest_available_energy(d, d.step.state_end, potential)
    balance.available_energy_start = balance.available_energy


def begin_window(d):
    """Begin a window of time, whose start is already set; WINDOW_CHANGE limits the energy change in it."""
    balance = d.balance
    balance.window_value = balance.value_end
    # `least_allowed_change` is the part of a step's allowed change that does not depend on the state
    energy = balance.root_reference_energy * balance.root_reference_energy + balance.reference_energy
    balance.least_allowed_change = STEP_CHANGE * d.solver.tolerance * energy
    balance.allowed_change = balance.least_allowed_change


def evaluate_balance_at_end(d):
    """Evaluate the energy balance again at the end of the last step, where the next step begins."""
    locate_points(d, d.step.state_end)
    d.balance.value_end = energy_balance(d, d.step.state_end) - d.step.energy_added_end
    d.balance.break_count = d.step.break_count


def apply_next_input_piece(d):
    """Apply the next piece of the inputs, which continues the present piece without a jump.

    Two pieces of a prescribed motion meet only up to round-off, so the energy changes a little. This change
    counts as supplied energy.
    """
    if d.channel_count == 0:
        apply_inputs(d)
        return
    y = d.step.state_end
    locate_points(d, y)
    balance_before = energy_balance(d, y)
    apply_inputs(d)
    locate_points(d, y)
    count_supplied(d, energy_balance(d, y) - balance_before)


def restart_balance(d):
    """Continue the energy balance after a restart at the communication point.

    The available energy is set back to its value at the start of the last step. A new parameter may change
    the elastic energy of active contacts; this change does not count as an error of the run.
    """
    balance, value_before = d.balance, d.balance.value_start
    balance.available_energy = balance.available_energy_start
    if d.contacts.active_count > 0:
        evaluate_balance_at_end(d)
        balance.window_value += balance.value_end - value_before
        balance.run_value += balance.value_end - value_before
        balance.value_start = balance.value_end


def check_energy(d, theta):
    """Reject the last step if the energy balance changes too much from the step's start to its fraction θ.

    θ = −1 stands for the end of the step. If ``may_err_in_middle`` and its rate at the end is known, it is
    also rejected if its dense output is wrong in the middle (``is_middle_correct``).

    If the step loses more than NOTABLE_LOSS of its allowed loss (``loss_allowed``), its loss divided by the
    allowed loss counts as an error of the step. A quotient above 1 rejects the step, unless the loss is only
    round-off: then the quotient counts as 1. A quotient up to 1 affects the size of the next step.

    Returns:
        Two energies [J] for ``store_energy``: the energy balance at θ; and the available energy, which is the
        most that motion, springs, walls and heat can have had from the start of the run until θ.
    """
    balance, y = d.balance, d.step.state_end
    if theta >= 0.0:
        y = d.scratch.state
        interpolate_state(d.step, theta, y)
        locate_points(d, y)
    else:
        ensure_rate(d)
        ensure_points(d)
    kinetic, potential = mechanical_energy(d, y)
    present_value = kinetic + potential + other_energy(d, y) - d.step.energy_added
    change = present_value - balance.value_end
    available = largest_available_energy(d, y, potential)
    # `not <=` is also true for a NaN; `abs(change) > allowed` would accept a NaN
    if not abs(change) <= balance.least_allowed_change:
        allowed = allowed_change(d, y)
        if not abs(change) <= allowed:
            reject_step(d, CHECK_FAILED)
            return present_value, available
        balance.allowed_change = max(balance.allowed_change, allowed)
    if change > SLIGHT_GAIN * available and present_value - balance.run_value > ENERGY_GAIN * available:
        reject_step(d, CHECK_FAILED)
        return present_value, available
    loss = -change / loss_allowed(d, available) if change < 0.0 else 0.0
    if loss > 1.0 and not -change > allowed_round_off(d, y):
        loss = 1.0
    if loss > NOTABLE_LOSS:
        set_outcome(d, max(d.trial.error, loss), d.trial.cost_factor)
    if is_accepted(d) and d.step.rate_known and may_err_in_middle(d) and not is_middle_correct(d):
        reject_step(d, CHECK_FAILED)
    return present_value, available


def store_energy(d, present_value, available):
    """Store the energy balance ``present_value`` [J] and the energy ``available`` [J] at a step's end.

    Both are results of ``check_energy``.
    """
    balance = d.balance
    balance.value_start, balance.available_energy_start = balance.value_end, balance.available_energy
    balance.value_end, balance.available_energy = present_value, available


def largest_available_energy(d, y, potential):
    """Return the available energy [J]: the most that motion, springs, walls and heat can have had so far.

    The present state y counts, too; ``potential`` is the potential energy [J] in y.
    """
    balance, supplied = d.balance, y[supplied_at(d.link_count)]
    return max(
        balance.available_energy,
        balance.least_allowed_change + balance.run_value - potential + max(0.0, supplied),
    )


def loss_allowed(d, available):
    """Return the energy [J], > 0, that the last step may lose by errors.

    The result is the largest of: the part of the loss B (``loss_budget``) that earlier steps have left, the
    growth of B in this step, and round-off. ``available``: the most [J] that motion, springs, walls and heat
    can have had up to the end of the step.
    """
    balance, budget = d.balance, loss_budget(d, available)
    fraction = (d.step.end - d.step.start) / (LOSS_TIME + d.step.end - balance.run_start)
    remaining_loss = budget - (balance.run_value - balance.value_end)
    return max(remaining_loss, fraction * budget, ENERGY_ROUND_OFF * available)


def loss_budget(d, available):
    """Return the energy B [J] that all steps of the run, up to the end of the last one, may lose by errors.

    ``available``: the most [J] that motion, springs, walls and heat can have had up to the end of the last
    step. Even if nothing of B is left, a step may lose round-off, or as much as B grows in this step
    (``loss_allowed``).
    """
    balance, speed = d.balance, math.sqrt(2.0 * available)
    loss = (
        ENERGY_LOSS
        * d.solver.tolerance
        * (speed * (speed + balance.root_reference_energy) + balance.reference_energy)
    )
    return loss * (1.0 + (d.step.end - balance.run_start) / LOSS_TIME)


def may_err_in_middle(d):
    """Return whether the last step is of a kind that can have a correct end although its middle is wrong.

    There are three kinds, all long:

    - at a loose tolerance, the first step of a run, whose size is a guess
    - a step whose dense output exists and in which a link has turned by more than LONG_TURN
    - an explicit step that is longer than the stable size (STABLE_STEP) for dampers and springs of drives
    """
    if d.statistics.steps == 0 and d.solver.tolerance > LOOSE_TOLERANCE:
        return True
    if d.step.dense_for == SOLVER_READER and largest_turn(d) > LONG_TURN:
        return True
    is_resisted = d.chain.has_springs_or_dampers and not was_implicit(d)
    return is_resisted and find_joint_stiffness(d, d.step.end - d.step.start) > STABLE_STEP


def is_middle_correct(d):
    """Return whether the dense output is correct at the middle of the last step.

    There the energy balance may have changed since the start of the step by at most MIDDLE_CHANGE times the
    allowed change, and the dissipated energy must lie between its values at both ends, up to a tolerance.
    """
    y = d.scratch.state
    ensure_dense(d, SOLVER_READER)
    interpolate_state(d.step, 0.5, y)
    if not dissipates_evenly(d, y[dissipated_at(d.link_count)]):
        return False
    locate_points(d, y)
    change = abs(energy_balance(d, y) - d.step.energy_added - d.balance.value_end)
    return (
        change <= MIDDLE_CHANGE * d.balance.least_allowed_change
        or change <= MIDDLE_CHANGE * allowed_change(d, y)
    )


def dissipates_evenly(d, middle):
    """Return whether ``middle`` lies between the dissipated energies at both ends of the last step.

    ``middle`` [J] is the dissipated energy in the middle of the step. The result is also true if ``middle``
    lies outside by at most MIDDLE_CHANGE × STEP_CHANGE × the tolerance × the scale that step_errors.py has
    for this energy.
    """
    start, end = d.step.state[dissipated_at(d.link_count)], d.step.state_end[dissipated_at(d.link_count)]
    scale = d.chain.energy_scale + abs(end) + impact_energy(d)
    slack = MIDDLE_CHANGE * STEP_CHANGE * d.solver.tolerance * scale
    return min(start, end) - slack <= middle <= max(start, end) + slack


def allowed_change(d, y):
    """Return the largest change [J] of the energy balance that is allowed to a step which ends in state y.

    The points must be located for y.
    """
    scale, summed = energy_scales(d, y)
    return STEP_CHANGE * d.solver.tolerance * scale + ENERGY_ROUND_OFF * summed


def allowed_round_off(d, y):
    """Return the part of ``allowed_change`` [J] that is round-off; the points must be located for y."""
    _, summed = energy_scales(d, y)
    return ENERGY_ROUND_OFF * summed


def check_balance(d):
    """Return ENERGY_NOT_KEPT if the energy balance has changed too much, else OK.

    The limit in a window of time is WINDOW_CHANGE × tolerance × S, plus round-off. The limits in the run so
    far are 2 G for a gain, with G = ENERGY_GAIN × the available energy, and twice the larger of G and
    ``loss_budget`` for a loss.
    """
    balance, largest_gain = d.balance, ENERGY_GAIN * d.balance.available_energy
    gain = balance.value_end - balance.run_value
    if abs(gain) > 2.0 * largest_gain and (
        gain > 0.0 or -gain > 2.0 * loss_budget(d, balance.available_energy)
    ):
        return ENERGY_NOT_KEPT
    if d.step.end >= balance.window_start + BALANCE_WINDOW:
        balance.window_start = d.step.end
        begin_window(d)
    fraction, drift = WINDOW_CHANGE / STEP_CHANGE, abs(balance.value_end - balance.window_value)
    if drift > fraction * balance.allowed_change:
        locate_points(d, d.step.state_end)
        balance.allowed_change = max(balance.allowed_change, allowed_change(d, d.step.state_end))
    return OK if drift <= fraction * balance.allowed_change else ENERGY_NOT_KEPT
