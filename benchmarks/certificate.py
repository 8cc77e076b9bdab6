"""A certificate for a single step: proofs about the events in the step, in ball arithmetic (Arb).

The dense output P of a step nearly obeys the equations, with the defect δ = P′ − f(P). With the logarithmic
norm µ of the Jacobian f′ on a tube around P, Gronwall's inequality bounds the difference to the solution y
that begins where the step begins, ‖T (y − P)‖ ≤ ∫ e^∫µ ‖T δ‖, as long as it stays within the tube. For each
candidate the clearances of P then decide: NO_EVENT, ONE_EVENT, UNDECIDED. No claim is made about a whole run:
its bound would grow like e^∫µ.

The equations are derived independently: Lagrange's, with an assembled mass matrix, and with the centre of
mass in place of a free base, x_k = x_C + Σ_j a_kj (cos θ_j, sin θ_j). The kernel's record gives the numbers
of the scene, the state at the start of the step, the dense output, and the values that a contact has latched
at its onset. The solution belongs to the phase of the step: a force that is cut off, or that damps on
approach only, is continued smoothly across its kink, sliding keeps its direction, and in the variable of a
contact its δ is δ* u². In this variable the verdicts on the other candidates hold up to the end of the
contact, u = 0, until which time increases.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from flint import arb, arb_poly, arb_series, ctx
from scipy.linalg import cholesky, eigh, solve_continuous_lyapunov

from chain_impact.kernel.events.marks import END, ONSET
from chain_impact.kernel.ode.dense import POWERS

NO_EVENT, ONE_EVENT, UNDECIDED = "no event", "one event", "undecided"
ORDER = 12  # degree of the Taylor polynomials in a part of a step
PARTS = (2, 6, 18, 54, 162)  # numbers of parts of a step, which are tried until all candidates are decided
# factor of the step's length up to which the search for an event marked at the end of the step continues
BEYOND = 1.01
MARGINS = (0.3, 1.0, 3.0, 10.0)  # margins of the logarithmic norm above the largest Re λ, over a step
TUBE, WIDEST = 1e-4, 0.1  # radius of the tube: first trial value, and an upper bound
FASTEST = 30.0  # largest ∫ µ over a part
DEEPEST = 14  # number of halvings of a part, after which a candidate remains undecided
ctx.prec = 90
# round-off of floats: relative for one operation with a margin, for a few operations, and absolute
ROUND_OFF, SLACK, TINY = 4e-16, 1 + 1e-9, 1e-300
Row = list[Any]


class RefusalError(ArithmeticError):
    """The bound does not exist, for a reason in words."""


class Step:
    """The last step of a record: its dense output, and equations for q, q̇, and u in a contact's variable.

    Attributes:
        size, kept: h [s of the step's variable], and the part of h that the step keeps.
        polynomials: the coefficients of each variable in powers of x = s/h, with the base in place of x_C.
        marked: the candidates whose contact begins or ends at the end of the step.
    """

    def __init__(self, d: Any) -> None:
        """Copy the needed data from the record."""
        step, touch, model, own = d["step"], d["touch"], d["model"], d["inputs"]
        self.links, self.pinned = int(d["links"]), bool(model["pinned"])
        self.size, self.kept = float(step["size"]), float(step["kept"])
        self.regularized, self.lever = int(step["regularized"]), float(model["size"])
        free = range(2 * self.pinned, self.links + 2)
        variables = [*free, *(self.links + 2 + j for j in free)]
        variables += [2 * self.links + 6] if self.regularized >= 0 else []
        self.free = len(free)
        self.first = self.free - self.links  # index of the first angle
        self.polynomials = [_powers(step["state"][j], step["dense"][:, j]) for j in variables]
        place = d["moved"]["position"] if model["base_moves"] else step["state"]
        self.base = [arb(float(value)) for value in place[:2]]
        self.marked = [c for c, event in enumerate(touch["event"]) if event in (ONSET, END)]
        self.gravity, self.tip = model["gravity"].tolist(), own["tip_force"].tolist()
        self._bodies(model)
        names = ("torque", "stiffness", "target_angle", "damping", "target_velocity")
        self.joints = [[float(own[f"joint_{name}"][i]) for name in names] for i in range(self.links)]
        for i, mode in enumerate(d["drive"]["mode"]):
            if mode or (i == 0 and not self.pinned):
                self.joints[i] = [float(mode * model["joint_torque_limit"][i]) if mode else 0.0, 0, 0, 0, 0]
        self.candidates = d["candidate"][["point", "stop", "normal_x", "normal_y"]].tolist()
        self.offsets = [arb(float(o)) + float(d["contact"]["radius"]) for o in d["candidate"]["offset"]]
        self.active = touch["active_index"][: touch["active_count"]].tolist()
        rubbing = d["element"]["index"][: d["friction"]["count"]].tolist()
        # unit force against the direction of sliding
        slides = {e: -float(d["element"]["mode"][e]) for e in rubbing}
        for i, joint in enumerate(self.joints):
            joint[0] = arb(joint[0]) + slides.get(len(self.candidates) + i, 0.0) * model["joint_friction"][i]
        self.drags = {c: arb(slides.get(c, 0.0)) * float(d["law"]["friction"][c]) for c in self.active}
        self.forces = {}  # K, n, d, p of F = K δⁿ + d δᵖ δ̇
        for c in self.active:
            law, beyond = d["law"][c], bool(touch["beyond_kink"][c])
            if not beyond or law["approach_only"]:
                damping = 0.0 if beyond else touch["damping"][c]
                numbers = law["stiffness"], law["exponent"], damping, law["rate_exponent"]
                self.forces[c] = [arb(float(number)) for number in numbers]
        unit = np.ones(len(variables))
        if self.active:
            unit[: 2 * self.free] = 1.0 / touch["depth_scale"][self.active].min()
        unit[self.free : 2 * self.free] *= self.size * self.kept
        self.unit = 2.0 ** np.round(np.log2(unit))  # units of errors: 1 over the scales of the variables
        self.scale = arb(float(touch["depth_scale"][self.regularized])) if self.regularized >= 0 else arb(1)

    def _bodies(self, model: Any) -> None:
        """Set the mass, a_kj, and A_ij of the mass matrix A_ij cos(θ_i − θ_j)."""
        names = ("length", "mass", "center_of_mass", "inertia")
        length, mass, middle, inertia = ([arb(x) for x in model[name].tolist()] for name in names)
        links = range(self.links)
        beyond = [sum(mass[i + 1 :], arb(0)) for i in links]
        moment = [mass[i] * middle[i] + length[i] * beyond[i] for i in links]
        self.mass = mass[0] + beyond[0]
        self.balance = [arb(0) if self.pinned else one / self.mass for one in moment]
        self.arms = [[length[j] * (j < k) - self.balance[j] for j in links] for k in (*links, self.links)]
        self.arms.append(moment if self.pinned else [arb(0)] * self.links)  # arms on which gravity acts
        self.masses = [[moment[max(i, j)] * length[min(i, j)] for j in links] for i in links]
        for i in links:
            self.masses[i][i] = inertia[i] + mass[i] * middle[i] ** 2 + length[i] ** 2 * beyond[i]
            for j in links:
                self.masses[i][j] -= self.balance[i] * self.balance[j] * self.mass

    def course(self, at: arb, order: int) -> tuple[Row, Row]:
        """Return the variables along P and their rates: Taylor series about x, or about all x of a ball."""
        ctx.cap = order + 1
        z = [_series(row, at) for row in self.polynomials]
        slopes = [[k * a for k, a in enumerate(row)][1:] for row in self.polynomials]
        rate = [_series(row, at) / arb(self.size) for row in slopes]
        n = self.free
        for j, share in enumerate(self.balance if self.first else []):
            i, angle = self.first + j, z[self.first + j]
            sin, cos = share * angle.sin(), share * angle.cos()
            z[0], z[1] = z[0] + cos, z[1] + sin
            rate[0], rate[1] = rate[0] - sin * rate[i], rate[1] + cos * rate[i]
            turn, spin = z[n + i] * rate[i], rate[n + i]
            z[n], z[n + 1] = z[n] - sin * z[n + i], z[n + 1] + cos * z[n + i]
            rate[n] -= cos * turn + sin * spin
            rate[n + 1] += cos * spin - sin * turn
        return z, rate

    def inertia(self, values: Row) -> list[Row]:
        """Return D: the mass matrix, and 1 for the other variables."""
        found = [[arb(int(i == j)) for j in range(len(values))] for i in range(len(values))]
        for k in range(self.first):
            found[self.free + k][self.free + k] = self.mass
        first = self.free + self.first
        for i in range(self.links):
            for j in range(self.links):
                turned = (values[self.first + i] - values[self.first + j]).cos() if i != j else 1
                found[first + i][first + j] = self.masses[i][j] * turned
        return found

    def residual(self, z: Row, rate: Row, asked: Any) -> tuple[Row, dict[int, tuple[Any, Any]]]:
        """Return D (z′ − f(z)) for a rate z′ in the step's variable, and g and ġ of some candidates."""
        n, links, zero = self.free, range(self.links), arb_series([0])
        theta, omega, alpha = z[self.first : n], z[n + self.first : 2 * n], rate[n + self.first : 2 * n]
        pace = z[-1] / (1 + z[-1] * z[-1]) if self.regularized >= 0 else arb_series([1])
        units = [(angle.cos(), angle.sin()) for angle in theta]
        gaps = {c: self._gap(c, z, units) for c in asked}
        loads, moments = [(self.links, *map(arb, self.tip))], [zero] * (self.links + 1)
        for i, (torque, stiffness, rest, damping, target) in enumerate(self.joints):
            turned, turning = theta[i] - (theta[i - 1] if i else 0), omega[i] - (omega[i - 1] if i else 0)
            moments[i] = torque - stiffness * (turned - rest) - damping * (turning - target)
        for c in self.forces:
            (point, stop, nx, ny), force = self.candidates[c], self._force(c, z, gaps[c])
            if stop:
                moments[point - 1] += stop * self.lever * force
            else:
                drag = self.drags[c]
                loads.append((point, (nx + drag * ny) * force, (ny - drag * nx) * force))
        rows = [rate[j] - pace * z[n + j] for j in range(n)]
        for k in range(self.first):
            force = sum((load[1 + k] for load in loads), self.mass * self.gravity[k])
            rows.append(self.mass * rate[n + k] - pace * force)
        loads += [(-1, *map(arb, self.gravity))]
        for i, (cos, sin) in enumerate(units):
            push = moments[i] - moments[i + 1]
            for point, fx, fy in loads:
                push += self.arms[point][i] * (fy * cos - fx * sin)
            row = self.masses[i][i] * alpha[i] - pace * push
            for j in links:
                if j != i:
                    cosine, sine = (theta[i] - theta[j]).cos(), (theta[i] - theta[j]).sin()
                    row += self.masses[i][j] * (cosine * alpha[j] + sine * pace * omega[j] * omega[j])
            rows.append(row)
        if self.regularized >= 0:
            rows.append(rate[-1] + gaps[self.regularized][1] / (2 * self.scale * (1 + z[-1] * z[-1])))
        return rows, gaps

    def _gap(self, c: int, z: Row, units: Row) -> tuple[Any, Any]:
        """Return the clearance of a candidate and its rate."""
        point, stop, nx, ny = self.candidates[c]
        first, n, gap, rate = self.first, self.free, -self.offsets[c], arb(0)
        if stop:
            for sign, j in ((1, point - 1), (-1, point - 2))[:point]:
                gap += sign * stop * self.lever * z[first + j]
                rate += sign * stop * self.lever * z[n + first + j]
            return gap, rate
        x, y = z[:2] if first else self.base
        gap += nx * x + ny * y
        rate += nx * z[n] + ny * z[n + 1] if first else 0
        for arm, (cos, sin), spin in zip(self.arms[point], units, z[n + first :], strict=False):
            gap += arm * (nx * cos + ny * sin)
            rate += arm * (ny * cos - nx * sin) * spin
        return gap, rate

    def rate(self, z: np.ndarray) -> np.ndarray:
        """Return f(z) in floats."""
        ctx.cap = 1
        series = [arb_series([arb(float(value))]) for value in z]
        rest, _ = self.residual(series, [arb_series([0])] * len(z), self.active)
        inertia = Matrix.of(self.inertia([value[0] for value in series])).middle
        return np.linalg.solve(inertia, [-float(row[0].mid()) for row in rest])

    def phi(self, c: int, z: Row, gap: tuple[Any, Any]) -> tuple[Any, Any]:
        """Return φ, which falls through zero at an event, and a rate with its sign: that of g, δ, or u."""
        if c not in self.active:
            return gap
        return z[-1] if c == self.regularized else -gap[0], -gap[1]

    def _force(self, c: int, z: Row, gap: tuple[Any, Any]) -> Any:
        """Return the force of a contact, from √δ, which in its own variable is u √δ*."""
        stiffness, exponent, damping, rate_exponent = self.forces[c]
        root = z[-1] * self.scale.sqrt() if c == self.regularized else (-gap[0]).sqrt()
        return stiffness * _power(root, 2 * exponent) - damping * _power(root, 2 * rate_exponent) * gap[1]


def _power(base: Any, exponent: arb) -> Any:
    """Return a power with an exponent ≥ 0; one that is not whole needs a base > 0."""
    whole = int(float(exponent))
    return base**whole if exponent == whole else (base.log() * exponent).exp()


def _powers(start: float, dense: np.ndarray) -> Row:
    """Return the coefficients of a component of the dense output in powers of x."""
    total = arb_poly([arb(float(start))])
    for (p, q), f in zip(POWERS, dense, strict=True):
        total += arb_poly([arb(float(f))]) * arb_poly([0, 1]) ** p * arb_poly([1, -1]) ** q
    return [total[k] for k in range(8)]


def _series(coefficients: Row, at: arb) -> Any:
    """Return the Taylor series of a polynomial about x, or about all x of a ball."""
    shifted = arb_poly(coefficients)(arb_poly([at, 1]))
    return arb_series([shifted[k] for k in range(min(8, ctx.cap))], ctx.cap)


class Matrix:
    """A matrix of balls with floats as middles and radii, whose products have small errors in each entry."""

    def __init__(self, middle: np.ndarray, radius: np.ndarray | float = 0.0) -> None:
        """Take floats."""
        self.middle, self.radius = middle, np.zeros_like(middle) + radius
        self.size = (np.abs(middle) + radius) * (1 + ROUND_OFF)  # bounds on the entries

    @classmethod
    def of(cls, rows: list[Row]) -> Matrix:
        """Return balls of floats that contain those of Arb."""
        middle = np.array([[float(entry.mid()) for entry in row] for row in rows])
        radius = np.array([[float(entry.rad()) for entry in row] for row in rows])
        return cls(middle, (radius + ROUND_OFF * np.abs(middle)) * (1 + ROUND_OFF))

    def __matmul__(self, other: Matrix) -> Matrix:
        """Return the product, with a bound on round-off."""
        size = np.abs(self.middle)
        spread = size @ other.radius + self.radius @ other.size
        spread += len(other.middle) * ROUND_OFF * (size @ np.abs(other.middle))
        return Matrix(self.middle @ other.middle, spread * SLACK + TINY)

    def solve(self, right: Matrix) -> Matrix:
        """Return Y with A Y = R, from Y = X R + (1 − X A) Y with an approximate inverse X of A.

        Raises:
            RefusalError: when this formula does not bound Y.
        """
        near = Matrix(np.linalg.inv(self.middle))
        first, rest = near @ right, near @ self
        left = np.abs(rest.middle - np.eye(len(rest.middle))) + rest.radius + ROUND_OFF
        share = float(left.sum(axis=1).max()) * SLACK
        if not share < 0.9:
            raise RefusalError("the mass matrix varies too much")
        once = left @ first.size
        spread = once + left.sum(axis=1)[:, None] * once.max(axis=0) / (1 - share)
        return Matrix(first.middle, (first.radius + spread) * SLACK)


class Linear:
    """The equations linearized on a box: D, and f′ = −D⁻¹ ∂(residual)/∂z, in the units of errors."""

    def __init__(self, step: Step, values: Row) -> None:
        """Compute the rate in the box, and differentiate the residual with respect to each variable."""
        ctx.cap = 2
        unit, nothing = step.unit, [arb_series([0], 2)] * len(values)
        z = [arb_series([value], 2) for value in values]
        inertia = Matrix.of(step.inertia(values))
        self.inertia = Matrix(*(part * unit[:, None] / unit for part in (inertia.middle, inertia.radius)))
        left = step.residual(z, nothing, step.active)[0]
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
        self.jacobian = self.inertia.solve(Matrix.of(list(zip(*columns, strict=True))))


class Part:
    """A part of a step, low ≤ x ≤ high: Taylor polynomials about its middle; the last term holds everywhere.

    Attributes:
        values: balls that hold the variables.
        defects: D (P′ − f(P)) in the units of errors, by powers of x − middle.
        courses: φ and its rate for each candidate, in the same form.
    """

    def __init__(self, step: Step, low: float, high: float) -> None:
        """Expand the functions in Taylor polynomials."""
        self.low, self.high, self.middle = low, high, 0.5 * (low + high)
        whole = arb(low).union(arb(high))
        self.radius = _upper(whole - self.middle)
        found, asked = [], range(len(step.candidates))
        for at in (arb(self.middle), whole):
            z, rate = step.course(at, ORDER)
            rows, gaps = step.residual(z, rate, asked)
            found.append((rows, [step.phi(c, z, gaps[c]) for c in asked]))
        self.values = [series[0] for series in z]
        (thin, courses), (wide, wide_courses) = found
        rows = zip(thin, wide, step.unit, strict=True)
        self.defects = Matrix.of([[float(u) * entry for entry in _joined(a, b)] for a, b, u in rows])
        self.courses = [tuple(map(_joined, a, b)) for a, b in zip(courses, wide_courses, strict=True)]

    def range_of(self, terms: Row, low: float, high: float) -> arb:
        """Return a ball that holds a function for all x in [low, high]."""
        x, centre = arb(low).union(arb(high)) - self.middle, arb(0.5 * (low + high)) - self.middle
        polynomial = arb_poly(terms[:-1])
        return polynomial(centre) + polynomial.derivative()(x) * (x - centre) + terms[-1] * x**ORDER


def _joined(thin: Any, wide: Any) -> Row:
    """Return the terms of a Taylor polynomial with Lagrange's remainder."""
    if min(thin.prec, wide.prec) <= ORDER:
        raise RefusalError("a force is not smooth")
    return [*(thin[k] for k in range(ORDER)), wide[ORDER]]


def _upper(ball: arb) -> float:
    """Return a float that is not less than the size of a ball."""
    return math.nextafter(float(abs(ball).upper()), math.inf)


class Certificate:
    """A bound on ‖T (y − P)‖ over a step, and the verdict on each candidate.

    Attributes:
        error: the bound.
        verdicts: of each candidate.
    """

    def __init__(self, step: Step, count: int) -> None:
        """Divide the step into ``count`` parts.

        Raises:
            RefusalError: when there is no bound.
        """
        self.step, self.tube, self.error = step, TUBE, math.inf
        self._choose_norm()
        ends = np.linspace(0.0, step.kept, count + 1).tolist() + [BEYOND * step.kept] * bool(step.marked)
        self.parts: list[Part] = []
        self._bound(list(pairwise(ends)))
        self.verdicts = [self._decide(c) for c in range(len(step.candidates))]

    def _choose_norm(self) -> None:
        """Choose T by Lyapunov's equation, so that the logarithmic norm is small at points of the step."""
        step = self.step
        places = [arb(share * step.kept) for share in (0.5, 0.0, 1.0)]
        sample = [Linear(step, [z[0] for z in step.course(x, 0)[0]]) for x in places]
        found = [linear.jacobian.middle * (step.size * step.kept) for linear in sample]
        one, best = np.eye(len(step.unit)), math.inf
        edge = float(np.linalg.eigvals(found[0]).real.max())
        for margin in MARGINS:
            shifted = found[0] - (edge + margin) * one
            root = cholesky(solve_continuous_lyapunov(shifted.T, -one))
            turned = [root @ jacobian @ np.linalg.inv(root) for jacobian in found]
            growth = max(eigh(each + each.T)[0][-1] for each in turned)
            if growth < best:
                best, chosen = growth, eigh(turned[0] + turned[0].T)[1].T @ root
        self.to_norm = Matrix(chosen)
        self.from_norm = self.to_norm.solve(Matrix(one))
        self.reach = np.linalg.norm(self.from_norm.size, axis=1) / step.unit * SLACK
        self.reference = Matrix((sample[0].inertia @ self.from_norm).middle)

    def _bound(self, pieces: list[tuple[float, float]]) -> None:
        """Find a tube that contains y, and the bound at the end of the tube.

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
        """Return ∫ ‖T δ‖ over a part, and a bound on the integral of the logarithmic norm on the tube."""
        reach = self.tube * self.reach
        box = [value + arb(0, float(far)) for value, far in zip(part.values, reach, strict=True)]
        linear = Linear(self.step, box)
        near = self.reference.solve(part.defects)
        length = (part.high - part.low) * self.step.size
        size = float(np.linalg.norm(near.size @ np.power(part.radius, np.arange(ORDER + 1)))) * length
        rest = (self.to_norm @ linear.inertia.solve(self.reference)).size
        size *= math.sqrt(rest.sum(axis=0).max() * rest.sum(axis=1).max()) * SLACK
        turned = self.to_norm @ linear.jacobian @ self.from_norm
        aside = 0.5 * (np.abs(turned.middle + turned.middle.T) + turned.radius + turned.radius.T)
        np.fill_diagonal(aside, turned.middle.diagonal() + turned.radius.diagonal())
        growth = float(aside.sum(axis=1).max()) * length + 1e-9
        if not (size < WIDEST and growth < FASTEST):
            raise RefusalError("the bound grows too fast")
        return size, growth

    def spread(self, c: int) -> tuple[float, float]:
        """Return bounds on the differences of φ and of the rate of a candidate between y and P."""
        step, n = self.step, self.step.free
        far = self.error * self.reach
        point, stop, nx, ny = step.candidates[c]
        arms = np.array([abs(float(arm)) for arm in step.arms[point]])
        if stop:
            arms = step.lever * np.isin(np.arange(step.links), (point - 1, point - 2))
        turn, spin = far[step.first : n], far[n + step.first : 2 * n]
        speeds = [[_upper(w) for w in part.values[n + step.first : 2 * n]] for part in self.parts]
        fast = np.max(speeds, axis=0)
        gap, rate = arms @ turn, arms @ (spin + (0 if stop else (fast + spin) * turn))
        if step.first and not stop:
            gap += abs(nx) * far[0] + abs(ny) * far[1]
            rate += abs(nx) * far[n] + abs(ny) * far[n + 1]
        return float(far[-1] if c == step.regularized else gap) * SLACK, float(rate) * SLACK

    def _decide(self, c: int) -> str:
        """Return whether φ falls through zero in the step, or just beyond an end with a marked event."""
        balls = [arb(0, size) for size in self.spread(c)]
        parts = [part for part in self.parts if c in self.step.marked or part.high <= self.step.kept]
        waiting = [(part, part.low, part.high, 0) for part in reversed(parts)]
        # whether φ > 0 at the start of the interval, and whether φ began to fall there
        above, falling = False, False
        while waiting:
            part, low, high, depth = waiting.pop()
            terms = part.courses[c]
            phi, rate = (part.range_of(one, low, high) + ball for one, ball in zip(terms, balls, strict=True))
            start, end = (part.range_of(terms[0], x, x) + balls[0] for x in (low, high))
            if phi > 0:
                above, falling = True, False
            elif rate > 0 and not falling:
                above = bool(end > 0)
            elif rate < 0 and (falling or above or start > 0):
                if end < 0:
                    return ONE_EVENT
                above, falling = bool(end > 0), not end > 0
            elif depth < DEEPEST:
                middle = 0.5 * (low + high)
                waiting += [(part, middle, high, depth + 1), (part, low, middle, depth + 1)]
            else:
                return UNDECIDED
        return UNDECIDED if falling else NO_EVENT


def certify(step: Step) -> tuple[list[str], Certificate | str]:
    """Return the verdicts on all candidates, and the certificate or the reason why it does not exist."""
    found: Certificate | str = ""
    for count in PARTS:
        try:
            found = Certificate(step, count)
        except RefusalError as refusal:
            found = str(refusal)
        except (ValueError, ZeroDivisionError, np.linalg.LinAlgError):
            found = "a force is not smooth"
        if not isinstance(found, str) and UNDECIDED not in found.verdicts:
            break
    return [UNDECIDED] * len(step.candidates) if isinstance(found, str) else found.verdicts, found
