"""The mode of dry friction of a contact that begins without any tangential speed.

At the onset the normal force F and the limit of friction are zero. The ratio of the forces just after the
onset decides: F grows, and the tangential force that keeps the point from sliding grows in proportion to F,
with a ratio that follows from the chain's inertia. The point sticks if this tangential force is at most µ_s
F; otherwise the point slides against it.
"""

from chain_impact.kernel.cost import count_other_cost
from chain_impact.kernel.forces.force_formula import law_force
from chain_impact.kernel.forces.friction import STICKS, against, list_sticking, set_mode
from chain_impact.kernel.forces.holding import start_from_loads
from chain_impact.kernel.rows.constraints import activate_all, solve_equality
from chain_impact.kernel.rows.geometry import add_along, clear_loads_of, normal_row

# [s] The time after an onset at which the forces are compared. For several contacts that begin at the same
# moment, the ratio of their normal forces is that of this time.
SOON = 1e-6


def begins(d, e):
    """Return whether element e is the friction of a contact that begins now."""
    return e < d.candidates and d.touch.active[e] != 0 and d.touch.onset[e] == d.step.end


def decide_onsets(d):
    """Choose the modes of contacts that begin now and may stick, for the located points."""
    friction, open_ones = d.friction, 0
    for i in range(friction.contact_count):
        open_ones += is_open(d, d.element.index[i])
    if open_ones == 0:
        return
    list_sticking(d)
    clear_loads_of(d, d.scratch.load)
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        if begins(d, c):
            add_along(normal_row(d, c), d.scratch.load, force_soon(d, c))
    scale = start_from_loads(d)
    activate_all(d)
    solve_equality(d, scale)
    count_other_cost(d, 1)
    for i in range(friction.stuck_count):
        e = d.element.stuck[i]
        force = d.constraints.impulse[d.touch.active_count + i]
        if is_open(d, e) and abs(force) > d.law.static_friction[e] * force_soon(d, e):
            set_mode(d, e, against(force))


def is_open(d, e):
    """Return whether element e begins now, at rest along its wall."""
    return begins(d, e) and d.element.undecided[e] != 0 and d.element.mode[e] == STICKS


def force_soon(d, c):
    """Return the normal force [N], shortly after the onset, of a contact that begins now."""
    speed = d.touch.onset_speed[c]
    force, _ = law_force(d, c, SOON * speed, speed)
    return force
