"""Radau IIA with 5 stages: the coefficients, and the simplified Newton iteration for the stages.

Collocation at the zeros c_i of P_4 − P_5, Legendre's polynomials shifted to [0, 1]: order 9, stage order 5,
L-stable and stiffly accurate. Source: E. Hairer and G. Wanner 1996, *Solving Ordinary Differential Equations
II*, 2nd ed., Springer, section IV.5; for 5 stages, the same authors 1999, J Comput Appl Math 111:93. The
coefficients are verified in tests/kernel/ode/test_radau.py.

The matrix Q of the method has one real eigenvalue and two pairs of complex eigenvalues. The rows of LEFT are
the left eigenvectors, with the real and imaginary parts of a pair in successive rows; the columns of RIGHT
are the right eigenvectors, such that RIGHT · LEFT = 1. RIGHT includes the factor 2 for the two conjugate
eigenvalues of a pair.

A step of size h starts at the state z_0 and has the states z_i at its stages. The increments u_i = z_i − z_0,
the rows of U, solve U = h Q F(z_0 + U), where F are the rates at the stages. With one approximate Jacobian A
for all stages, an iteration solves (1 − h Q ⊗ A) ΔU = R, R = h Q F − U. In the eigenvectors of Q there is
one system (1 − h μ A) w = r for the real eigenvalue μ of Q and one for each pair of complex eigenvalues. The
right-hand sides r are the rows of LEFT · R; with the solutions w as the rows of W, ΔU = RIGHT · W.

The terms that A leaves out cause more iterations, but no loss of accuracy: each correction is about θ ≈ h
|∂f/∂z − A| times the correction before. The iteration has converged when the estimate of the remaining error,
θ/(1 − θ) times the last correction or, if less, this correction, is at most ITERATION_ERROR.
"""

import math

from chain_impact.kernel.combinators import join_functions
from chain_impact.kernel.mathematics.powers import power
from chain_impact.kernel.record.constants import RADAU_STAGES

# fmt: off
RADAU_NODES = (0.05710419611451768, 0.2768430136381238, 0.5835904323689168, 0.8602401356562195,
    1.0)
# row i, column j of the matrix Q: the integral, from 0 to RADAU_NODES[i], of the j-th Lagrange polynomial of
# the nodes
Q: tuple[tuple[float, ...], ...] = (
    (0.07299886431790333, -0.02673533110794557, 0.018676929763984353,
     -0.01287910609330644, 0.005042839233882015),
    (0.15377523147918246, 0.14621486784749352, -0.03644456890512809,
     0.02123306311930472, -0.007935579902728777),
    (0.14006304568480987, 0.29896712949128346, 0.16758507013524895,
     -0.03396910168661774, 0.010944288744192253),
    (0.14489430810953477, 0.2765000687601592, 0.32579792291042103,
     0.12875675325490976, -0.015708917378805327),
    (0.14371356079122594, 0.28135601514946207, 0.31182652297574126,
     0.22310390108357075, 0.04),
)
REAL_EIGENVALUE = 0.15906584442746913
# for each pair of conjugate eigenvalues of Q: the real part, and the imaginary part that is > 0
COMPLEX_EIGENVALUES = ((0.06506577854574362, 0.11646852774031707), (0.1331790770182996, 0.07499451183581853))
LEFT: tuple[tuple[float, ...], ...] = (
    (27.697693775684087, 12.783337911304406, 3.20848938671343,
     -0.9514904122489162, 0.7415504960259897),
    (2.672093218917456, 2.2968077838795806, -1.5181801617297122,
     0.5253300951157295, -0.13638930593214812),
    (-1.8740299037199024, 1.9924828681719424, 0.5222078208040094,
     -0.5920492840689743, 0.22495888507839018),
    (-16.5209401067595, -8.688476739531783, -0.08606453162700278,
     -0.04958488899127132, 0.2656140579191533),
    (4.305721989937646, -4.849995704764404, -0.9573643198484372,
     -1.20934600304247, 0.5237317439676688),
)
RIGHT: tuple[tuple[float, ...], ...] = (
    (0.013576867344947943, -0.020484095635817653, -0.09534775458059144,
     -0.02295703051045903, 0.02803971778575082),
    (0.0016179004017190875, 0.10034572903474212, 0.18866363836322286,
     -0.015337661498360326, -0.049417156853037054),
    (0.07915785334744721, -0.4610790680868359, -0.2054060907602518,
     0.0387969279976579, -0.16360070740750235),
    (0.41225608268046143, 0.7557878044977225, -0.9334882606649887,
     0.8152023425603981, -0.39936485577360503),
    (1.0, 2.0, 0.0,
     2.0, 0.0),
)
# START_WEIGHTS extrapolate the values at all nodes to the start of the step, 0; END_WEIGHTS extrapolate the
# values at all nodes except the last to the end of the step, 1.
START_WEIGHTS = (1.5864079001863283, -1.008117881498373, 0.7309748661597875, -0.5092648848477427,
    0.2)
END_WEIGHTS = (-0.4529527392493014, 1.3954519620824528, -2.1329496909650074, 2.1904504681318557)
# fmt: on


START_AND_NODES = (0.0, *RADAU_NODES)
LEFT_Q = tuple(
    tuple(math.fsum(left * row[j] for left, row in zip(one, Q, strict=True)) for j in range(RADAU_STAGES))
    for one in LEFT
)
# the largest number of Newton iterations in a step: if a step needs more, shorter steps cost less
MOST_ITERATIONS = 10
ITERATION_ERROR = 0.1  # the error that the iteration may leave in the stages, relative to the tolerance
# if a correction, from the third on, is more than DIVERGENCE_RATE times the correction before (their ratio θ
# is the convergence rate), the iteration is given up
DIVERGENCE_RATE = 0.95
# the largest correction, relative to the tolerance; if a correction is larger, the iteration has failed
FAILED_CORRECTION = 1e20


def lagrange_polynomial(first, m, x):
    """Return at x the polynomial that is 1 at START_AND_NODES[m], and 0 at the others from ``first`` on."""
    value = 1.0
    for k in range(first, RADAU_STAGES + 1):
        if k != m:
            value *= (x - START_AND_NODES[k]) / (START_AND_NODES[m] - START_AND_NODES[k])
    return value


def shift_of(pair, h):
    """Return the shift h μ [s] of a step of size h, for a complex eigenvalue μ of the matrix Q.

    ``pair`` is the index of the eigenvalue in COMPLEX_EIGENVALUES.
    """
    real, imaginary = COMPLEX_EIGENVALUES[pair]
    return complex(h * real, h * imaginary)


def _transformed(i):
    """Return a function (d, h, component_count) that sets right-hand side i to row i of LEFT · R."""
    rate_weights, stage_weights = LEFT_Q[i], LEFT[i]

    def transformed(d, h, component_count):
        implicit = d.implicit
        for j in range(component_count):
            rates, stages = 0.0, 0.0
            for m in range(RADAU_STAGES):
                rates += rate_weights[m] * implicit.rates[m, j]
                stages += stage_weights[m] * implicit.stages[m, j]
            implicit.right_hand_sides[i, j] = h * rates - stages

    return transformed


def _correct(d, component_count):
    """Add RIGHT · W to the stages; set ``implicit.z_scratch`` to the largest |change| of each component.

    The rows of W are the solutions of the linear systems, in ``implicit.right_hand_sides``.
    """
    implicit = d.implicit
    # this loop has no sum or maximum over the components, so that the compiler can use vector instructions
    for j in range(component_count):
        largest = 0.0
        for i in range(RADAU_STAGES):
            change = 0.0
            for m in range(RADAU_STAGES):
                change += RIGHT[i][m] * implicit.right_hand_sides[m, j]
            implicit.stages[i, j] += change
            largest = max(largest, abs(change))
        implicit.z_scratch[j] = largest


_transform = join_functions(*(_transformed(i) for i in range(RADAU_STAGES)))


def simplified_newton(begin, rate, note, linearize, factorize, solve):
    """Return the functions of the iteration for a right-hand side and its linear systems.

    Args:
        begin: function (d) that each iteration calls before it evaluates the stages.
        rate: function (d, z, elapsed, out) that sets ``out`` to the rate f(z) at the state z, ``elapsed`` [s]
            after the start of the step.
        note: function (d, stage) that is called after the rate at a stage has been evaluated.
        linearize: function (d, z) that evaluates the derivatives in A at the state z, for which ``rate`` was
            just called.
        factorize: function (d, h) that factorizes the systems.
        solve: function (d, h, component_count) that replaces the right-hand sides r in the rows of
            ``implicit.right_hand_sides`` by the solutions w.

    Returns:
        Three functions (d, h, component_count) for a step of size h [s]; ``component_count`` is the length of
        z. The first sets the right-hand sides of an iteration, the second corrects the stages in
        ``implicit.stages`` by the solutions. The third iterates, and returns whether the iteration has
        converged.
    """

    def find_residuals(d, h, component_count):
        implicit = d.implicit
        begin(d)
        for i in range(RADAU_STAGES):
            # the middle stage comes last, because the approximate Jacobian A is evaluated at the state of
            # this stage
            stage = (i + RADAU_STAGES // 2 + 1) % RADAU_STAGES
            for j in range(component_count):
                implicit.z_scratch[j] = implicit.z_start[j] + implicit.stages[stage, j]
            rate(d, implicit.z_scratch, h * RADAU_NODES[stage], implicit.rates[stage])
            note(d, stage)
        _transform(d, h, component_count)

    def correct_stages(d, _h, component_count):
        implicit, largest_correction, total = d.implicit, 0.0, 0.0
        _correct(d, component_count)
        for j in range(component_count):
            # a NaN in a solution reaches this sum through the last stage; max() could hide the NaN
            total += implicit.error_weight[j] * implicit.stages[RADAU_STAGES - 1, j]
            largest_correction = max(largest_correction, implicit.error_weight[j] * implicit.z_scratch[j])
        implicit.relative_correction = largest_correction if math.isfinite(total) else math.inf

    def converge(d, h, component_count):
        implicit = d.implicit
        correction_before = 0.0
        for k in range(1, MOST_ITERATIONS + 1):
            find_residuals(d, h, component_count)
            if k == 1:
                linearize(d, implicit.z_scratch)
                factorize(d, h)
            solve(d, h, component_count)
            correct_stages(d, h, component_count)
            implicit.iterations = k
            if not implicit.relative_correction < FAILED_CORRECTION:
                implicit.convergence_rate = math.inf
                return False
            theta = implicit.relative_correction / correction_before if correction_before > 0.0 else 0.0
            correction_before, implicit.convergence_rate = implicit.relative_correction, theta
            # The first correction does not show the convergence rate, so there is always a second one: while
            # the chain is at rest, the first correction is small, but the remaining error may be larger than
            # this correction.
            if k == 1:
                continue
            ratio = min(1.0, theta / (1.0 - theta)) if theta < 1.0 else 1.0
            if ratio * implicit.relative_correction <= ITERATION_ERROR:
                return True
            # the iteration diverges, or will not converge within MOST_ITERATIONS
            if k > 2 and theta > DIVERGENCE_RATE:
                return False
            if (
                k > 2
                and power(theta, float(MOST_ITERATIONS - k)) / (1.0 - theta) * implicit.relative_correction
                > ITERATION_ERROR
            ):
                return False
        return False

    return find_residuals, correct_stages, converge
