"""The equations of a single step and its dense output, in ball arithmetic (Arb).

The equations are derived independently of the kernel: they are Lagrange's, with an assembled mass matrix, and
with the centre of mass in place of a free base, x_k = x_C + Σ_j a_kj (cos θ_j, sin θ_j). The kernel's record
gives the numbers of the scene, the state at the start of the step, the dense output, and the values that a
contact has latched at its onset. The equations are those of the step's phase: a force that is cut off, or
that damps on approach only, is continued smoothly across its kink, and sliding keeps its direction. A step in
the variable u of a contact has δ = δ* u² for this contact. In this variable the verdicts on the other
candidates hold up to the end of the contact at u = 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb, arb_poly, arb_series, ctx

from benchmarks.balls import Matrix, Row
from chain_impact.kernel.ode.dense_output import BASIS_POWERS
from chain_impact.kernel.record.constants import CONTACT_ENDS, ONSET


class Step:
    """The last step of a record: its dense output, and equations for q, q̇, and u in a contact's variable.

    Attributes:
        size, kept: the length h of the step in its variable, and the part of h that the step keeps.
        polynomials: the coefficients of each variable in powers of x = s/h, with the base in place of x_C.
        marked: the candidates whose contact begins or ends at the end of the step.
    """

    def __init__(self, d: Any) -> None:
        """Copy the needed data from the record."""
        step, touch, chain, inputs = d["step"], d["contacts"], d["chain"], d["inputs"]
        self.links, self.pinned = int(d["link_count"]), bool(chain["has_base_joint"])
        self.size, self.kept = float(step["size"]), float(step["end_fraction"])
        self.regularized_candidate, self.lever = (
            int(step["regularized_candidate"]),
            float(chain["longest_link"]),
        )
        coordinates = range(2 * self.pinned, self.links + 2)
        variables = [*coordinates, *(self.links + 2 + j for j in coordinates)]
        variables += [2 * self.links + 6] if self.regularized_candidate >= 0 else []
        self.free = len(coordinates)
        self.first = self.free - self.links  # index of the first angle
        self.polynomials = [_powers(step["state"][j], step["dense"][:, j]) for j in variables]
        place = d["channel"]["position"] if chain["base_moves"] else step["state"]
        self.base = [arb(float(value)) for value in place[:2]]
        self.marked = [c for c, event in enumerate(touch["event"]) if event in (ONSET, CONTACT_ENDS)]
        self.gravity, self.tip = chain["gravity"].tolist(), inputs["tip_force"].tolist()
        self._bodies(chain)
        names = ("motor", "drive_stiffness", "target", "drive_damping", "target_velocity")
        self.joints = [[float(inputs[name][i]) for name in names] for i in range(self.links)]
        for i, mode in enumerate(d["drive"]["mode"][: self.links]):
            if mode or (i == 0 and not self.pinned):
                self.joints[i] = [float(mode * d["drive"]["limit"][i]) if mode else 0.0, 0, 0, 0, 0]
        self.candidates = d["candidate"][["point", "stop", "normal_x", "normal_y"]].tolist()
        self.offsets = [
            arb(float(o)) + float(d["contact_settings"]["radius"]) for o in d["candidate"]["offset"]
        ]
        self.active = touch["active_index"][: touch["active_count"]].tolist()
        rubbing = d["friction_element"]["index"][: d["friction"]["active_count"]].tolist()
        # element → −1 or 1: the sign of the dry friction, against the direction of sliding
        slides = {e: -float(d["friction_element"]["mode"][e]) for e in rubbing}
        for i, joint in enumerate(self.joints):
            joint[0] = arb(joint[0]) + slides.get(len(self.candidates) + i, 0.0) * d["drive"]["friction"][i]
        self.drags = {c: arb(slides.get(c, 0.0)) * float(d["law"]["friction"][c]) for c in self.active}
        self.forces = {}  # stiffness K, exponents n and p, and damping d of the force F = K δⁿ + d δᵖ δ̇
        for c in self.active:
            law, is_beyond = d["law"][c], bool(touch["beyond_kink"][c])
            if not is_beyond or law["approach_only"]:
                damping = 0.0 if is_beyond else touch["damping"][c]
                numbers = law["stiffness"], law["exponent"], damping, law["rate_exponent"]
                self.forces[c] = [arb(float(number)) for number in numbers]
        unit = np.ones(len(variables))
        if self.active:
            unit[: 2 * self.free] = 1.0 / touch["expected_penetration"][self.active].min()
        unit[self.free : 2 * self.free] *= self.size * self.kept
        # units of errors: 1 divided by the scales of the variables
        self.unit = 2.0 ** np.round(np.log2(unit))
        self.scale = (
            arb(float(touch["expected_penetration"][self.regularized_candidate]))
            if self.regularized_candidate >= 0
            else arb(1)
        )

    def _bodies(self, chain: Any) -> None:
        """Set the masses, the arms a_kj, and the factors A_ij of the mass matrix A_ij cos(θ_i − θ_j)."""
        names = ("length", "mass", "center_of_mass", "inertia")
        length, mass, middle, inertia = ([arb(x) for x in chain[name].tolist()] for name in names)
        links = range(self.links)
        outer_masses = [sum(mass[i + 1 :], arb(0)) for i in links]
        moment = [mass[i] * middle[i] + length[i] * outer_masses[i] for i in links]
        self.mass = mass[0] + outer_masses[0]
        self.balance = [arb(0) if self.pinned else value / self.mass for value in moment]
        self.arms = [[length[j] * (j < k) - self.balance[j] for j in links] for k in (*links, self.links)]
        self.arms.append(moment if self.pinned else [arb(0)] * self.links)  # arms on which gravity acts
        self.masses = [[moment[max(i, j)] * length[min(i, j)] for j in links] for i in links]
        for i in links:
            self.masses[i][i] = inertia[i] + mass[i] * middle[i] ** 2 + length[i] ** 2 * outer_masses[i]
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
        """Return the matrix D: the mass matrix, and 1 on the diagonal for the other variables."""
        matrix = [[arb(int(i == j)) for j in range(len(values))] for i in range(len(values))]
        for k in range(self.first):
            matrix[self.free + k][self.free + k] = self.mass
        first = self.free + self.first
        for i in range(self.links):
            for j in range(self.links):
                cosine = (values[self.first + i] - values[self.first + j]).cos() if i != j else 1
                matrix[first + i][first + j] = self.masses[i][j] * cosine
        return matrix

    def residual(self, z: Row, rate: Row, candidates: Any) -> tuple[Row, dict[int, tuple[Any, Any]]]:
        """Return D (z′ − f(z)) for a rate z′ in the step's variable, and g and ġ of some candidates."""
        n, links, zero = self.free, range(self.links), arb_series([0])
        theta, omega, alpha = z[self.first : n], z[n + self.first : 2 * n], rate[n + self.first : 2 * n]
        pace = z[-1] / (1 + z[-1] * z[-1]) if self.regularized_candidate >= 0 else arb_series([1])
        units = [(angle.cos(), angle.sin()) for angle in theta]
        gaps = {c: self._gap(c, z, units) for c in candidates}
        moments = [zero] * (self.links + 1)
        loads: list[tuple[int, Any, Any]] = [(self.links, arb(self.tip[0]), arb(self.tip[1]))]
        for i, (torque, stiffness, rest, damping, target) in enumerate(self.joints):
            joint_angle, joint_rate = (
                theta[i] - (theta[i - 1] if i else 0),
                omega[i] - (omega[i - 1] if i else 0),
            )
            moments[i] = torque - stiffness * (joint_angle - rest) - damping * (joint_rate - target)
        for c in self.forces:
            (point, stop, nx, ny), force = self.candidates[c], self._force(c, z, gaps[c])
            if stop:
                moments[point - 1] += stop * self.lever * force
            else:
                drag = self.drags[c]
                loads.append((point, (nx + drag * ny) * force, (ny - drag * nx) * force))
        rows = [rate[j] - pace * z[n + j] for j in range(n)]
        for k in range(self.first):
            force = sum(((fx, fy)[k] for _, fx, fy in loads), self.mass * self.gravity[k])
            rows.append(self.mass * rate[n + k] - pace * force)
        loads.append((-1, arb(self.gravity[0]), arb(self.gravity[1])))
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
        if self.regularized_candidate >= 0:
            rows.append(
                rate[-1] + gaps[self.regularized_candidate][1] / (2 * self.scale * (1 + z[-1] * z[-1]))
            )
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
        """Return the event function φ of candidate c, which falls through zero at an event, and a rate.

        The rate has the sign of the rate of φ; it is that of the clearance g, the penetration δ, or u.
        """
        if c not in self.active:
            return gap
        return z[-1] if c == self.regularized_candidate else -gap[0], -gap[1]

    def _force(self, c: int, z: Row, gap: tuple[Any, Any]) -> Any:
        """Return the force of a contact, from √δ, which in its own variable is u √δ*."""
        stiffness, exponent, damping, rate_exponent = self.forces[c]
        root = z[-1] * self.scale.sqrt() if c == self.regularized_candidate else (-gap[0]).sqrt()
        return stiffness * _power(root, 2 * exponent) - damping * _power(root, 2 * rate_exponent) * gap[1]


def _power(base: Any, exponent: arb) -> Any:
    """Return a power with an exponent ≥ 0; one that is not whole needs a base > 0."""
    whole_exponent = int(float(exponent))
    return base**whole_exponent if exponent == whole_exponent else (base.log() * exponent).exp()


def _powers(start: float, dense: np.ndarray) -> Row:
    """Return the coefficients of a component of the dense output in powers of x."""
    total = arb_poly([arb(float(start))])
    for (p, q), f in zip(BASIS_POWERS, dense, strict=True):
        total += arb_poly([arb(float(f))]) * arb_poly([0, 1]) ** p * arb_poly([1, -1]) ** q
    return [total[k] for k in range(8)]


def _series(coefficients: Row, at: arb) -> Any:
    """Return the Taylor series of a polynomial about x, or about all x of a ball."""
    shifted = arb_poly(coefficients)(arb_poly([at, 1]))
    return arb_series([shifted[k] for k in range(min(8, ctx.cap))], ctx.cap)
