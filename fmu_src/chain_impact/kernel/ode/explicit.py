"""The explicit step of order 8, DOP853, for flight and impact: coefficients and functions.

Explicit Runge–Kutta method of order 8 with 12 stages, two embedded error estimates of orders 5 and 3, and
dense output of order 7 by three further stages. The rate at the end of a step is the first stage of the next.
Source: E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., Springer
1993, section II.5 and the authors' code; J. R. Dormand and P. J. Prince 1981, J Comput Appl Math 7:67 for the
family.

A stage k_j is the rate dy/ds at a state y within the step; s is the step's integration variable. Each row of
coefficients is a dictionary from the number j of a stage to its coefficient; zeros are left out.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.signals import rate_of_base
from chain_impact.kernel.combinators import join_functions
from chain_impact.kernel.constraints.geometry import clearance_acceleration, clearance_and_rate, has_sticking
from chain_impact.kernel.cost import count_evaluations
from chain_impact.kernel.function_marks import inlined
from chain_impact.kernel.ode.quadratures import set_quadrature_stage, set_quadrature_stage_at_end
from chain_impact.kernel.ode.step_control import END_OVERSHOOT, reject_step, set_outcome
from chain_impact.kernel.ode.step_errors import controlled_count, scaled_errors, set_clearance_errors
from chain_impact.kernel.ode.sundman import regularize_rate, regularized_rate, root_curvature, runs_back
from chain_impact.kernel.record.constants import NO_CONTACT, STAGE_COUNT, TIME_REVERSED
from chain_impact.kernel.record.method import is_regularized
from chain_impact.kernel.record.state import sundman_u_at

# The number of stages of a step, 0 to 11. Stage 12 is the rate at the end of the step; stages 13 to 15 are
# only for the dense output.
STEP_STAGES = 12

# fmt: off
# row i has the coefficients A[i][j] of the state at which stage i is evaluated, y + h Σ_j A[i][j] k_j
A: tuple[dict[int, float], ...] = (
    {},
    {0: 0.05260015195876773},
    {0: 0.0197250569845379, 1: 0.0591751709536137},
    {0: 0.02958758547680685, 2: 0.08876275643042054},
    {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
    {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
    {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
    {0: 0.03709200011850479, 3: 0.17038392571223998, 4: 0.10726203044637328,
     5: -0.015319437748624402, 6: 0.008273789163814023},
    {0: 0.6241109587160757, 3: -3.3608926294469414, 4: -0.868219346841726, 5: 27.59209969944671,
     6: 20.154067550477894, 7: -43.48988418106996},
    {0: 0.47766253643826434, 3: -2.4881146199716677, 4: -0.590290826836843, 5: 21.230051448181193,
     6: 15.279233632882423, 7: -33.28821096898486, 8: -0.020331201708508627},
    {0: -0.9371424300859873, 3: 5.186372428844064, 4: 1.0914373489967295, 5: -8.149787010746927,
     6: -18.52006565999696, 7: 22.739487099350505, 8: 2.4936055526796523, 9: -3.0467644718982196},
    {0: 2.273310147516538, 3: -10.53449546673725, 4: -2.0008720582248625, 5: -17.9589318631188,
     6: 27.94888452941996, 7: -2.8589982771350235, 8: -8.87285693353063, 9: 12.360567175794303,
     10: 0.6433927460157636},
    {0: 0.054293734116568765, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585,
     8: 0.3111643669578199, 9: -0.1521609496625161, 10: 0.20136540080403034,
     11: 0.04471061572777259},
    {0: 0.056167502283047954, 6: 0.25350021021662483, 7: -0.2462390374708025,
     8: -0.12419142326381637, 9: 0.15329179827876568, 10: 0.00820105229563469,
     11: 0.007567897660545699, 12: -0.008298},
    {0: 0.03183464816350214, 5: 0.028300909672366776, 6: 0.053541988307438566,
     7: -0.05492374857139099, 10: -0.00010834732869724932, 11: 0.0003825710908356584,
     12: -0.00034046500868740456, 13: 0.1413124436746325},
    {0: -0.42889630158379194, 5: -4.697621415361164, 6: 7.683421196062599, 7: 4.06898981839711,
     8: 0.3567271874552811, 12: -0.0013990241651590145, 13: 2.9475147891527724,
     14: -9.15095847217987},
)

# weights B[j] of the method of order 8: the step ends at y + h Σ_j B[j] k_j, with the stages k_j. Stage 12 is
# evaluated at this end of the step, so A[12] is B
B = A[STEP_STAGES]

# weights E[j] of the error estimates h Σ_j E[j] k_j of orders 5 and 3, with the stages k_j
E5 = {0: 0.01312004499419488, 5: -1.2251564463762044, 6: -0.4957589496572502,
       7: 1.6643771824549864, 8: -0.35032884874997366, 9: 0.3341791187130175,
       10: 0.08192320648511571, 11: -0.022355307863886294}
E3 = {0: -0.18980075407240762, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585,
       8: -0.4226823213237919, 9: -0.1521609496625161, 10: 0.20136540080403034,
       11: 0.02265179219836082}

# weights D[i][j] of the four highest coefficients h Σ_j D[i][j] k_j of the interpolant, with the stages k_j
D: tuple[dict[int, float], ...] = (
    {0: -8.428938276109013, 5: 0.5667149535193777, 6: -3.0689499459498917, 7: 2.38466765651207,
     8: 2.117034582445028, 9: -0.871391583777973, 10: 2.2404374302607883, 11: 0.6315787787694688,
     12: -0.08899033645133331, 13: 18.148505520854727, 14: -9.194632392478356,
     15: -4.436036387594894},
    {0: 10.427508642579134, 5: 242.28349177525817, 6: 165.20045171727028, 7: -374.5467547226902,
     8: -22.113666853125306, 9: 7.733432668472264, 10: -30.674084731089398, 11: -9.332130526430229,
     12: 15.697238121770845, 13: -31.139403219565178, 14: -9.35292435884448, 15: 35.81684148639408},
    {0: 19.985053242002433, 5: -387.0373087493518, 6: -189.17813819516758, 7: 527.8081592054236,
     8: -11.57390253995963, 9: 6.8812326946963, 10: -1.0006050966910838, 11: 0.7777137798053443,
     12: -2.778205752353508, 13: -60.19669523126412, 14: 84.32040550667716, 15: 11.99229113618279},
    {0: -25.69393346270375, 5: -154.18974869023643, 6: -231.5293791760455, 7: 357.6391179106141,
     8: 93.40532418362432, 9: -37.45832313645163, 10: 104.0996495089623, 11: 29.8402934266605,
     12: -43.53345659001114, 13: 96.32455395918828, 14: -39.17726167561544, 15: -149.72683625798564},
)
# fmt: on


# index of the stage at the end of a step
END_STAGE = STEP_STAGES
# Near the first predicted end of a contact, a step is END_OVERSHOOT times as long as the way to this end, in
# the step's integration variable, if this length is less than LARGEST_STRETCH times the size that the errors
# allow. Otherwise the step covers at most half of this way, so that the following step is not tiny.
LARGEST_STRETCH = 1.2
# A contact whose predicted end is nearer than UNRESOLVED_PART times the next step's size has practically no
# force left: its penetration may be round-off. The step then ignores this end, and the search for events
# finds the end in the step. A step up to such an end could be shorter than the resolution of time.
UNRESOLVED_PART = 1e-6
# An error, relative to the tolerance, beyond one of these limits is not squared, because the square could
# underflow or overflow. Errors below the lower limit occur while the chain is at rest, because held points
# hardly have a speed.
SQUARE_UNDERFLOWS, SQUARE_OVERFLOWS = 1e-100, 1e100
# If the phase of a sine signal of the base advances by more than FAST_SINE [rad] in a step, the sine
# determines the error of the step (``is_smooth``).
FAST_SINE = 0.35
# Number of evaluations of the right-hand side in a step: stages 1 to 11. Stage 0 is known, and ``find_rate``
# (last_step.py) counts the evaluation at the end of the step.
STEP_EVALUATIONS = END_STAGE - 1
# the cost of the dense output, as a number of evaluations of the right-hand side: stages 13 to 15, and one
# more for the other operations
DENSE_EVALUATIONS = STAGE_COUNT - END_STAGE


def make_weighted_sum(row):
    """Return a function of (stages, j) with the value Σ_m row[m] stages[m, j].

    ``row`` maps each stage m in the sum to its coefficient.
    """
    names, coefficients = tuple(row), tuple(row.values())
    count = len(row)

    def summed(stages, j):
        total = 0.0
        for m in range(count):
            total += coefficients[m] * stages[names[m], j]
        return total

    return inlined(summed)


def make_combination(row):
    """Return a function that computes out = base + h Σ_m row[m] k_m, unrolled over the stages m in the row.

    The function takes (stages, base, h, out). Row m of ``stages`` is the stage k_m. The sum is computed for
    as many components as ``base`` has.
    """
    summed = make_weighted_sum(row)

    def combine(stages, base, h, out):
        for j in range(len(base)):
            out[j] = base[j] + h * summed(stages, j)

    return combine


def make_two_combinations(first_row, second_row):
    """Return a function for the sums h Σ_j row[j] k_j of two rows, which reads each stage k_j only once.

    The returned function takes (stages, h, first, second); it writes the sum of ``first_row`` to ``first``,
    and the sum of ``second_row`` to ``second``.
    """
    names = tuple(sorted({*first_row, *second_row}))
    row_1, row_2 = (tuple(row.get(name, 0.0) for name in names) for row in (first_row, second_row))
    count = len(names)

    def combine(stages, h, first, second):
        for j in range(len(first)):
            total_1, total_2 = 0.0, 0.0
            for m in range(count):
                stage = stages[names[m], j]
                total_1 += row_1[m] * stage
                total_2 += row_2[m] * stage
            first[j], second[j] = h * total_1, h * total_2

    return combine


def _stage(i, accepted):
    """Return a function (d, h) that computes stage i of a step of size h: the state there, and its rate.

    ``accepted`` is false for the tried step, which starts at ``step.state_end``, and true for the last step,
    which started at ``step.state``; the dense output needs further stages of the last step.
    """
    combine = make_combination(A[i])

    def stage(d, h):
        combine(d.scratch.stage, d.step.state if accepted else d.step.state_end, h, d.scratch.state)
        regularized_rate(d, d.scratch.state, d.scratch.stage[i])
        set_quadrature_stage(d, i)

    return stage


_stages = join_functions(*(_stage(i, accepted=False) for i in range(1, END_STAGE)))
_step_end, _step_sum = make_combination(B), make_weighted_sum(B)
_dense_stages = join_functions(*(_stage(i, accepted=True) for i in range(END_STAGE + 1, STAGE_COUNT)))
_errors = make_two_combinations(E5, E3)
_high_01, _high_23 = make_two_combinations(*D[:2]), make_two_combinations(*D[2:])


def size_toward_end(d, h):
    """Return the size of the next step; h is the size that the errors allow, both in the step's variable.

    Near the predicted end of a contact with a force law, the step either passes this end, and may then be up
    to LARGEST_STRETCH times as long as h, or covers at most half of the way to this end (``size_up_to_end``).
    """
    if d.contacts.force_law_count == 0:
        return h
    if not is_regularized(d):
        return size_toward_ends(d, h)
    root = sundman_u_at(d.link_count)
    u, slope = d.step.state_end[root], d.scratch.stage[0, root]
    if u + 2.0 * slope * h >= 0.0:
        return h
    accelerate_points(d, d.step.state_end, d.scratch.rate_start)
    # the contact ends after the fictitious time s at which u is zero: u + u′ s + ½ u″ s² = 0
    square = slope * slope - 2.0 * u * root_curvature(d, u, slope)
    time_left = 2.0 * u / (math.sqrt(max(0.0, square)) - slope)
    return size_up_to_end(h, time_left)


def size_toward_ends(d, h):
    """Return the size [s] of the next step, which runs in time; h [s] is the size that the errors allow.

    If a contact with a force law is predicted to end soon, the step either passes the first such end or
    covers at most half of the time until then (``size_up_to_end``).
    """
    accelerate_points(d, d.step.state_end, d.scratch.rate_start)
    time_left = math.inf
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        clearance, clearance_rate = clearance_and_rate(d, c)
        if clearance < 0.0 < clearance_rate:
            # the clearance g is zero after the time t: g + ġ t + ½ g̈ t² = 0
            square = clearance_rate * clearance_rate - 2.0 * clearance * clearance_acceleration(d, c)
            time_left = min(time_left, -2.0 * clearance / (clearance_rate + math.sqrt(max(0.0, square))))
    return size_up_to_end(h, time_left)


def size_up_to_end(h, time_left):
    """Return the size of the next step if the errors allow h and a contact ends after ``time_left``.

    Both h and ``time_left``, an estimate, are in the step's integration variable.
    """
    if time_left < UNRESOLVED_PART * h:
        return h
    if END_OVERSHOOT * time_left < LARGEST_STRETCH * h:
        return END_OVERSHOOT * time_left
    return min(h, 0.5 * time_left)


def integrate_trial(d, h):
    """Try a step of size h from the state ``step.state_end``.

    ``trial`` gets the state at the end of the step, the outcome and, unless the step runs back, the error
    relative to the tolerance.
    """
    make_step(d, h)
    count_evaluations(d, STEP_EVALUATIONS)
    if runs_back(d, d.trial.state):
        reject_step(d, TIME_REVERSED)
    else:
        set_outcome(d, error_estimate(d, h), 1.0)


def error_estimate(d, h):
    """Return the error of the tried step of size h, relative to the tolerance.

    The result is infinite if the step is not finite, or if an error estimate is too large to be squared
    (SQUARE_OVERFLOWS).
    """
    controlled = controlled_count(d)
    _errors(d.scratch.stage, h, d.scratch.y_error[0, :controlled], d.scratch.y_error[1, :controlled])
    if d.contacts.active_count > 0 or has_sticking(d):
        locate_points(d, d.trial.state)
    set_clearance_errors(d, 0)
    set_clearance_errors(d, 1)
    error_5, error_3 = scaled_errors(d)
    if error_5 < SQUARE_UNDERFLOWS:
        return error_5
    if max(error_5, error_3) > SQUARE_OVERFLOWS:
        return math.inf
    # the error e₅²/√(e₅² + e₃²/100), with the estimates e₅ and e₃ of orders 5 and 3, is of order 8, because
    # e₅/e₃ is of order 2 (Hairer, Nørsett, Wanner); if ``is_smooth``, √ratio makes it order 9
    ratio = error_5 / math.sqrt(error_5 * error_5 + 0.01 * error_3 * error_3)
    return error_5 * ratio * (math.sqrt(ratio) if is_smooth(d, h) else 1.0)


def is_smooth(d, h):
    """Return whether the motion is so smooth that the error of a step of size h is estimated with order 9.

    This holds in a regularized contact, and in flight with a fast sine signal of the base: the errors of
    steps within a period of the sine have both signs, and nearly cancel. In any other motion the order of the
    estimate is 8, as a margin. The order is also 8 in a regularized contact whose damping has an exponent of
    the penetration between 0 and 1/2: at the onset the force then rises more steeply than u, and the step
    loses its order of accuracy.
    """
    c = d.step.regularized_candidate
    if d.contacts.active_count == 0 and d.chain.base_moves:
        return h * rate_of_base(d) > FAST_SINE
    return c != NO_CONTACT and not 0.0 < d.law.rate_exponent[c] < 0.5


def make_step(d, h):
    """Make a step of size h from ``step.state_end`` to ``trial.state``, without an estimate of the error."""
    _stages(d, h)
    _step_end(d.scratch.stage, d.step.state_end, h, d.trial.state)
    quadrature, count = d.quadrature, d.quadrature.count
    if count > 0:
        _step_end(quadrature.stage, quadrature.state_end[:count], h, quadrature.tried_state[:count])


def step_increment(d, j):
    """Return the change of component j of y in the tried explicit step, without the round-off of adding to y.

    The difference of the states at both ends would contain this round-off.
    """
    return d.trial.size * _step_sum(d.scratch.stage, j)


def set_dense_output(d, h):
    """Set the dense output of the last step, of size h."""
    locate_points(d, d.step.state_end)
    regularize_rate(d, d.step.state_end, d.scratch.rate_end, d.scratch.stage[END_STAGE])
    set_quadrature_stage_at_end(d, END_STAGE)
    _dense_stages(d, h)
    _interpolant(d.step, d.scratch.stage, len(d.scratch.state), h)
    if d.quadrature.count > 0:
        _interpolant(d.quadrature, d.quadrature.stage, d.quadrature.count, h)


def _interpolant(step, stages, count, h):
    """Set the dense output of the first ``count`` components of ``step``: ``d.step`` or ``d.quadrature``.

    ``stages`` are the stages of these components in the last step, of size h.
    """
    for j in range(count):
        # the interpolant is y₀ + θ(F₀ + (1−θ)(F₁ + θ(F₂ + (1−θ)(F₃ + θ(F₄ + (1−θ)(F₅ + θ F₆)))))), with the
        # fraction θ of the step in its integration variable and the coefficients F_m, the rows m of ``dense``
        change = step.state_end[j] - step.state[j]
        step.dense[0, j] = change
        step.dense[1, j] = h * stages[0, j] - change
        step.dense[2, j] = 2.0 * change - h * (stages[END_STAGE, j] + stages[0, j])
    _high_01(stages, h, step.dense[3, :count], step.dense[4, :count])
    _high_23(stages, h, step.dense[5, :count], step.dense[6, :count])
