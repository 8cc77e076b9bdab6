"""A certificate for a single step: proofs about the events in the step, in ball arithmetic (Arb).

The dense output P of a step nearly obeys the equations, with the defect δ = P′ − f(P). With a matrix T of new
coordinates, in which rates grow little, and the logarithmic norm µ of the Jacobian f′ on a tube around P,
Gronwall's inequality bounds the difference to the solution y that begins where the step begins, ‖T (y − P)‖ ≤
∫ e^∫µ ‖T δ‖, as long as y stays within the tube. For each candidate the clearances of P then decide:
NO_EVENT, ONE_EVENT, UNDECIDED. No claim is made about a whole run: its bound would grow like e^∫µ. The
equations are in step_equations.py.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from flint import arb, arb_poly, arb_series, ctx
from scipy.linalg import cholesky, eigh, solve_continuous_lyapunov

from benchmarks.balls import SLACK, Matrix, RefusalError, Row
from benchmarks.step_equations import Step

NO_EVENT, ONE_EVENT, UNDECIDED = "no event", "one event", "undecided"
ORDER = 12  # degree of the Taylor polynomials in a part of a step
# numbers of parts of a step; the next number is tried as long as the verdict on a candidate is UNDECIDED
PARTS = (2, 6, 18, 54, 162)
# factor of the step's length up to which the search for an event marked at the end of the step continues
END_OF_SEARCH = 1.01
# margins of the logarithmic norm above the largest Re λ of the Jacobian, multiplied by the length of a step
MARGINS = (0.3, 1.0, 3.0, 10.0)
TUBE, WIDEST = 1e-4, 0.1  # radius of the tube: first trial value, and an upper bound
FASTEST = 30.0  # largest integral ∫ µ of the logarithmic norm over the time of a part of a step
DEEPEST = 14  # number of halvings of a part, after which a candidate remains undecided


class Linear:
    """The equations linearized on a box, in the units of errors: the mass matrix D and the Jacobian f′.

    For the state z and a residual D (z′ − f(z)) the Jacobian is f′ = −D⁻¹ ∂(residual)/∂z.
    """

    def __init__(self, step: Step, values: Row) -> None:
        """Compute the rate in the box, and differentiate the residual with respect to each variable."""
        ctx.cap = 2
        unit, zeros = step.unit, [arb_series([0], 2)] * len(values)
        z = [arb_series([value], 2) for value in values]
        inertia = Matrix.of(step.inertia(values))
        self.inertia = Matrix(*(part * unit[:, None] / unit for part in (inertia.middle, inertia.radius)))
        left = step.residual(z, zeros, step.active)[0]
        rate = self.inertia.solve(
            Matrix.of([[-row[0] * float(u)] for row, u in zip(left, unit, strict=True)])
        )
        balls = zip(rate.middle[:, 0], rate.radius[:, 0], unit, strict=True)
        rates = [arb_series([arb(float(m), float(r)) / float(u)], 2) for m, r, u in balls]
        columns = []
        for j, value in enumerate(values):
            seeded = [*z]
            seeded[j] = arb_series([value, 1 / float(unit[j])], 2)
            rows = step.residual(seeded, rates, step.active)[0]
            columns.append([-row[1] * float(u) for row, u in zip(rows, unit, strict=True)])
        self.jacobian = self.inertia.solve(Matrix.of([list(row) for row in zip(*columns, strict=True)]))


class Part:
    """A part of a step, low ≤ x ≤ high: Taylor polynomials about its middle; the last term holds everywhere.

    Attributes:
        values: balls that hold the variables.
        defects: D (P′ − f(P)) in the units of errors, by powers of x − middle.
        courses: the event function φ and its rate for each candidate, in the same form.
    """

    def __init__(self, step: Step, low: float, high: float) -> None:
        """Expand the functions in Taylor polynomials."""
        self.low, self.high, self.middle = low, high, 0.5 * (low + high)
        interval = arb(low).union(arb(high))
        self.radius = _upper(interval - self.middle)
        expansions, candidates = [], range(len(step.candidates))
        for at in (arb(self.middle), interval):
            z, rate = step.course(at, ORDER)
            rows, gaps = step.residual(z, rate, candidates)
            expansions.append((rows, [step.phi(c, z, gaps[c]) for c in candidates]))
        self.values = [series[0] for series in z]
        (terms, courses), (remainders, wide_courses) = expansions
        joined = zip(terms, remainders, step.unit, strict=True)
        self.defects = Matrix.of([[float(u) * entry for entry in _joined(a, b)] for a, b, u in joined])
        self.courses = [tuple(map(_joined, a, b)) for a, b in zip(courses, wide_courses, strict=True)]

    def range_of(self, terms: Row, low: float, high: float) -> arb:
        """Return a ball with all values in [low, high] of a function, given by its Taylor polynomial.

        ``terms``: the coefficients about the middle of the part, and the remainder.
        """
        x, centre = arb(low).union(arb(high)) - self.middle, arb(0.5 * (low + high)) - self.middle
        polynomial = arb_poly(terms[:-1])
        value: arb = polynomial(centre) + polynomial.derivative()(x) * (x - centre) + terms[-1] * x**ORDER
        return value


def _joined(series: Any, remainder_series: Any) -> Row:
    """Return the terms of a Taylor polynomial with Lagrange's remainder, the last term.

    ``series`` is about the middle of a part, ``remainder_series`` about the ball of all places.
    """
    if min(series.prec, remainder_series.prec) <= ORDER:
        raise RefusalError("a force is not smooth")
    return [*(series[k] for k in range(ORDER)), remainder_series[ORDER]]


def _upper(ball: arb) -> float:
    """Return a float that is not less than the magnitude of any number in a ball."""
    return math.nextafter(float(abs(ball).upper()), math.inf)


class Certificate:
    """A bound on the error of the dense output P of a step, and the verdict on each candidate.

    Attributes:
        error: the bound on ‖T (y − P)‖ over the step, see the head of this module.
        verdicts: NO_EVENT, ONE_EVENT or UNDECIDED for each candidate.
    """

    def __init__(self, step: Step, count: int) -> None:
        """Divide the step into ``count`` parts.

        Raises:
            RefusalError: when there is no bound.
        """
        self.step, self.tube, self.error = step, TUBE, math.inf
        self._choose_norm()
        ends = np.linspace(0.0, step.kept, count + 1).tolist() + [END_OF_SEARCH * step.kept] * bool(
            step.marked
        )
        self.parts: list[Part] = []
        self._bound(list(pairwise(ends)))
        self.verdicts = [self._decide(c) for c in range(len(step.candidates))]

    def _choose_norm(self) -> None:
        """Choose T by Lyapunov's equation so that the logarithmic norm is small in the step."""
        step = self.step
        places = [arb(share * step.kept) for share in (0.5, 0.0, 1.0)]
        sample = [Linear(step, [z[0] for z in step.course(x, 0)[0]]) for x in places]
        jacobians = [linear.jacobian.middle * (step.size * step.kept) for linear in sample]
        identity, best = np.eye(len(step.unit)), math.inf
        edge = float(np.linalg.eigvals(jacobians[0]).real.max())
        for margin in MARGINS:
            shifted = jacobians[0] - (edge + margin) * identity
            root = cholesky(solve_continuous_lyapunov(shifted.T, -identity))
            transformed = [root @ jacobian @ np.linalg.inv(root) for jacobian in jacobians]
            growth = max(eigh(matrix + matrix.T)[0][-1] for matrix in transformed)
            if growth < best:
                best, transformation = growth, eigh(transformed[0] + transformed[0].T)[1].T @ root
        self.to_norm = Matrix(transformation)
        self.from_norm = self.to_norm.solve(Matrix(identity))
        self.reach = np.linalg.norm(self.from_norm.size, axis=1) / step.unit * SLACK
        self.reference = Matrix((sample[0].inertia @ self.from_norm).middle)

    def _bound(self, pieces: list[tuple[float, float]]) -> None:
        """Find the radius of a tube that contains y, and the bound ``error``; ``pieces``: ends of the parts.

        Raises:
            RefusalError: when no tube is found.
        """
        for _ in range(4):
            error = 0.0
            for k, piece in enumerate(pieces):
                if k == len(self.parts):
                    self.parts.append(Part(self.step, *piece))
                size, growth = self._of_part(self.parts[k])
                error = (error + size) * math.exp(max(0.0, growth)) * SLACK
                if not error < WIDEST:
                    raise RefusalError("the bound grows too fast")
            if error <= self.tube:
                self.error = error
                return
            self.tube = 2.0 * error
        raise RefusalError("the bound grows too fast")

    def _of_part(self, part: Part) -> tuple[float, float]:
        """Return bounds on two integrals over a part: ∫ ‖T δ‖ of the defect, ∫ µ of the logarithmic norm.

        The bound on µ holds on the tube.
        """
        reach = self.tube * self.reach
        box = [value + arb(0, float(margin)) for value, margin in zip(part.values, reach, strict=True)]
        linear = Linear(self.step, box)
        scaled_defects = self.reference.solve(part.defects)
        length = (part.high - part.low) * self.step.size
        size = (
            float(np.linalg.norm(scaled_defects.size @ np.power(part.radius, np.arange(ORDER + 1)))) * length
        )
        rest = (self.to_norm @ linear.inertia.solve(self.reference)).size
        size *= math.sqrt(rest.sum(axis=0).max() * rest.sum(axis=1).max()) * SLACK
        transformed = self.to_norm @ linear.jacobian @ self.from_norm
        aside = 0.5 * (
            np.abs(transformed.middle + transformed.middle.T) + transformed.radius + transformed.radius.T
        )
        np.fill_diagonal(aside, transformed.middle.diagonal() + transformed.radius.diagonal())
        growth = float(aside.sum(axis=1).max()) * length + 1e-9
        if not (size < WIDEST and growth < FASTEST):
            raise RefusalError("the bound grows too fast")
        return size, growth

    def spread(self, c: int) -> tuple[float, float]:
        """Return bounds on the differences of φ and of its rate between solution y and dense output P.

        φ is the event function of candidate ``c``.
        """
        step, n = self.step, self.step.free
        margins = self.error * self.reach
        point, stop, nx, ny = step.candidates[c]
        arms = np.array([abs(float(arm)) for arm in step.arms[point]])
        if stop:
            arms = step.lever * np.isin(np.arange(step.links), (point - 1, point - 2))
        turn, spin = margins[step.first : n], margins[n + step.first : 2 * n]
        speeds = [[_upper(w) for w in part.values[n + step.first : 2 * n]] for part in self.parts]
        fastest_rates = np.max(speeds, axis=0)
        gap, rate = arms @ turn, arms @ (spin + (0 if stop else (fastest_rates + spin) * turn))
        if step.first and not stop:
            gap += abs(nx) * margins[0] + abs(ny) * margins[1]
            rate += abs(nx) * margins[n] + abs(ny) * margins[n + 1]
        return float(margins[-1] if c == step.regularized_candidate else gap) * SLACK, float(rate) * SLACK

    def _decide(self, c: int) -> str:
        """Return the verdict on candidate c: whether its event function falls through zero in the step.

        If the event at an end of the step is marked, a fall just beyond this end counts as well.
        """
        balls = [arb(0, size) for size in self.spread(c)]
        parts = [part for part in self.parts if c in self.step.marked or part.high <= self.step.kept]
        waiting = [(part, part.low, part.high, 0) for part in reversed(parts)]
        # is_positive: the event function is known to be positive at the start of the interval; may_fall: it
        # was positive before, has fallen up to this start, and its sign there is not known
        is_positive, may_fall = False, False
        while waiting:
            part, low, high, depth = waiting.pop()
            terms = part.courses[c]
            phi, rate = (
                part.range_of(polynomial, low, high) + ball
                for polynomial, ball in zip(terms, balls, strict=True)
            )
            start, end = (part.range_of(terms[0], x, x) + balls[0] for x in (low, high))
            if phi > 0:
                is_positive, may_fall = True, False
            elif rate > 0 and not may_fall:
                is_positive = bool(end > 0)
            elif rate < 0 and (may_fall or is_positive or start > 0):
                if end < 0:
                    return ONE_EVENT
                is_positive, may_fall = bool(end > 0), not end > 0
            elif depth < DEEPEST:
                middle = 0.5 * (low + high)
                waiting += [(part, middle, high, depth + 1), (part, low, middle, depth + 1)]
            else:
                return UNDECIDED
        return UNDECIDED if may_fall else NO_EVENT


def certify(step: Step) -> tuple[list[str], Certificate | str]:
    """Return the verdicts on all candidates, and the certificate or the reason why it does not exist."""
    result: Certificate | str = ""
    for count in PARTS:
        try:
            result = Certificate(step, count)
        except RefusalError as refusal:
            result = str(refusal)
        except (ValueError, ZeroDivisionError, np.linalg.LinAlgError):
            result = "a force is not smooth"
        if not isinstance(result, str) and UNDECIDED not in result.verdicts:
            break
    return [UNDECIDED] * len(step.candidates) if isinstance(result, str) else result.verdicts, result
