"""The model as expressions, for peers that differentiate or compile it themselves.

The recursion of plain_chain.py, written once for any algebra: heyoka's symbols, JAX's tracers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from plain_chain import Chain

Loads = dict[int, list[Any]]
"""Point → force on it along x and y [N]."""


def links(chain: Chain, algebra: Any, q: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Vectors along the links [m]."""
    count = range(len(chain.length))
    x = [float(chain.length[i]) * algebra.cos(q[2 + i]) for i in count]
    y = [float(chain.length[i]) * algebra.sin(q[2 + i]) for i in count]
    return x, y


def clearances(chain: Chain, algebra: Any, q: Sequence[Any], v: Sequence[Any]) -> list[tuple[Any, Any]]:
    """Clearance [m] and its rate [m/s] of each candidate."""
    lx, ly = links(chain, algebra, q)
    place, speed = [(q[0], q[1])], [(v[0], v[1])]
    for i in range(len(chain.length)):
        place.append((place[i][0] + lx[i], place[i][1] + ly[i]))
        speed.append((speed[i][0] - v[2 + i] * ly[i], speed[i][1] + v[2 + i] * lx[i]))
    found = []
    for point, wall in zip(chain.candidate_point, chain.candidate_wall, strict=True):
        side, axis = 1.0 - 2.0 * (int(wall) % 2), int(wall) // 2
        found.append((side * (place[point][axis] - float(chain.wall[wall])), side * speed[point][axis]))
    return found


def push(chain: Chain, loads: Loads, c: int, force: Any) -> None:
    """Add the force of a candidate to the loads [N]."""
    load, wall = loads.setdefault(int(chain.candidate_point[c]), [0.0, 0.0]), int(chain.candidate_wall[c])
    load[wall // 2] = load[wall // 2] + (1.0 - 2.0 * (wall % 2)) * force


def accelerations(chain: Chain, algebra: Any, q: Sequence[Any], v: Sequence[Any], loads: Loads) -> list[Any]:
    """q̈ by the recursion, see plain_chain.accelerations."""
    n = len(chain.length)
    gx, gy = (float(value) for value in chain.gravity)
    lx, ly = links(chain, algebra, q)
    axx, axy, ayy = 0.0, 0.0, 0.0
    bx, by = (-value for value in loads.get(n, (0.0, 0.0)))
    gains: list[tuple[Any, Any, Any]] = [(0.0, 0.0, 0.0)] * n
    for i in range(n - 1, -1, -1):
        m, w2 = float(chain.mass[i]), v[2 + i] * v[2 + i]
        sx, sy = m * float(chain.ratio[i]) * lx[i], m * float(chain.ratio[i]) * ly[i]
        px, py = axy * lx[i] - axx * ly[i], ayy * lx[i] - axy * ly[i]
        dx = bx - w2 * (axx * lx[i] + axy * ly[i])
        dy = by - w2 * (axy * lx[i] + ayy * ly[i])
        hx, hy = px - sy, py + sx
        inverse = 1.0 / (float(chain.joint_inertia[i]) + lx[i] * py - ly[i] * px)
        h0 = lx[i] * dy - ly[i] * dx + sy * gx - sx * gy
        kx, ky = hx * inverse, hy * inverse
        axx, axy, ayy = axx + m - hx * kx, axy - hx * ky, ayy + m - hy * ky
        bx, by = dx - w2 * sx - m * gx - kx * h0, dy - w2 * sy - m * gy - ky * h0
        if i in loads:
            bx, by = bx - loads[i][0], by - loads[i][1]
        gains[i] = kx, ky, h0 * inverse
    determinant = axx * ayy - axy * axy
    ax, ay = (axy * by - ayy * bx) / determinant, (axy * bx - axx * by) / determinant
    out = [ax, ay]
    for i in range(n):
        a, w2 = -(gains[i][0] * ax + gains[i][1] * ay + gains[i][2]), v[2 + i] * v[2 + i]
        out.append(a)
        ax, ay = ax - (a * ly[i] + w2 * lx[i]), ay + a * lx[i] - w2 * ly[i]
    return out
