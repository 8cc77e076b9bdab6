"""Lagrange's equations of a chain, by SymPy."""

import functools

import numpy as np


@functools.cache
def lagrange(count):
    """Return functions M(q…) and h(q…) of Lagrange's equations M q̈ = h, from T, V, D and virtual work."""
    import sympy  # here, because the import takes a second

    n = count
    q = sympy.symbols(f"x y theta0:{n}")
    qd = sympy.symbols(f"vx vy omega0:{n}")
    m, length, centre, inertia, damping, stiffness, rest, torque = (
        sympy.symbols(f"{name}0:{n}") for name in ("m", "l", "c", "I", "d", "k", "phi", "u")
    )
    gx, gy, pinned = sympy.symbols("gx gy pinned")
    load = sympy.symbols(f"f0:{2 * (n + 1)}")
    time_derivative = lambda e: sum(e.diff(a) * b for a, b in zip(q, qd, strict=True))  # noqa: E731

    joint = sympy.Matrix(q[:2])
    kinetic = potential = rayleigh = work = 0
    for i in range(n):
        work += load[2 * i] * joint[0] + load[2 * i + 1] * joint[1]
        along = sympy.Matrix([sympy.cos(q[2 + i]), sympy.sin(q[2 + i])])
        mass_centre = joint + centre[i] * along
        velocity = mass_centre.applyfunc(time_derivative)
        kinetic += m[i] * velocity.dot(velocity) / 2 + inertia[i] * qd[2 + i] ** 2 / 2
        potential -= m[i] * (gx * mass_centre[0] + gy * mass_centre[1])
        # joint i rotates link i against link i − 1; the first joint rotates against the ground, if it exists
        held = pinned if i == 0 else 1
        before = (0, 0) if i == 0 else (q[1 + i], qd[1 + i])
        potential += held * stiffness[i] * (q[2 + i] - before[0] - rest[i]) ** 2 / 2
        rayleigh += held * damping[i] * (qd[2 + i] - before[1]) ** 2 / 2
        work += held * torque[i] * (q[2 + i] - before[0])
        joint = joint + length[i] * along
    work += load[2 * n] * joint[0] + load[2 * n + 1] * joint[1]

    lagrangian = kinetic - potential
    momenta = [lagrangian.diff(rate) for rate in qd]
    matrix = sympy.Matrix([[momentum.diff(rate) for rate in qd] for momentum in momenta])
    force = sympy.Matrix(
        [
            lagrangian.diff(a) + work.diff(a) - rayleigh.diff(b) - time_derivative(momentum)
            for a, b, momentum in zip(q, qd, momenta, strict=True)
        ]
    )
    arguments = [q, qd, m, length, centre, inertia, damping, stiffness, rest, torque, (gx, gy), pinned, load]
    return sympy.lambdify(arguments, matrix, cse=True), sympy.lambdify(arguments, force, cse=True)


def lagrange_accelerations(scene, angles, velocities, torques, loads):
    """Return q̈ = M⁻¹h, with ẍ₀ = ÿ₀ = 0 for a pinned base."""
    links = scene.chain.links
    pinned = scene.chain.base == "pinned"
    names = ("mass", "length", "center_of_mass", "inertia")
    names += ("joint_damping", "joint_stiffness", "joint_rest_angle")
    columns = [[getattr(link, name) for link in links] for name in names]
    arguments = [(0.0, 0.0, *angles), velocities, *columns, torques, scene.gravity, pinned, loads.ravel()]
    matrix, force = (np.array(f(*arguments), float) for f in lagrange(len(links)))
    free = slice(2, None) if pinned else slice(None)
    result = np.zeros(len(links) + 2)
    result[free] = np.linalg.solve(matrix[free, free], force[free, 0])
    return result
