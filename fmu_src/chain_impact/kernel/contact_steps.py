"""The steps that contacts call for where the error control is blind: at their onset and at their end.

There the force rises as δⁿ from nothing, or falls to it, and is not smooth. At the onset the error of the
explicit step can be foretold: it is a part κ of the change in speed over the step, in units of its scale,
with κ the same for all stiffnesses, restitutions and tolerances (3.8e-5 to 4e-5 as measured).
"""

import math

from chain_impact.kernel.contact import along_normal, clearance
from chain_impact.kernel.contact_force import damping_share
from chain_impact.kernel.jit import jit

KAPPA = 5.5e-5  # κ, with a margin
SHORTEST = 1e-12  # s, an end nearer than this is none
LONGEST_FIRST = 0.12  # of the contact's time scale
APPROACH, BEYOND = 0.65, 1.1  # of the time to the end of a contact, for steps up to it and over it


@jit
def first_step(d, c):
    """The first step [s] of the contact of candidate c, which has just been latched."""
    touch = d.touch
    # the time in which the force stops the point: m v = (1 + λ) K vⁿ tⁿ⁺¹/(n+1) if it is damping
    share, power = damping_share(d, c), 1.0 / (d.contact.rate_exponent + 1.0)
    scale = touch.depth_scale[c] / touch.impact_speed[c] * (1.0 + share) ** -power
    # κ (h/scale)ⁿ⁺¹ blow = tolerance
    touch.blind_step[c] = scale * (d.solver.tolerance / (KAPPA * blow(d, c, share))) ** power
    return min(touch.blind_step[c], LONGEST_FIRST * scale)


@jit
def blow(d, c, share):
    """The largest change that stopping the point makes to speeds and lost energy, in units of their scales.

    The response of the chain to a unit impulse has to stand in ``work.y``, as ``effective_mass`` leaves it.
    """
    n, y = len(d.model.length), d.step.state_end
    speed, mass = d.touch.impact_speed[c], d.touch.effective_mass[c]
    worst = mass * speed * speed * share / (1.0 + share) / (d.model.energy + abs(y[2 * n + 4]))
    for j in range(n + 2):
        unit = d.model.size if j < 2 else 1.0
        change = mass * speed * abs(d.work.y[j])
        worst = max(worst, change / (unit + abs(y[n + 2 + j])))
    return worst


@jit
def toward_end(d):
    """The longest step [s] with respect to the ends of contacts: up to one, or over it if that is near."""
    longest = math.inf
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        gap, gap_rate = clearance(d, c)
        acceleration = along_normal(d, c, d.work.acceleration)
        # g + ġ t + ½ g̈ t² = 0
        square = gap_rate * gap_rate - 2.0 * acceleration * gap
        if gap < 0.0 < gap_rate and square > 0.0:
            left = max(SHORTEST, -2.0 * gap / (gap_rate + math.sqrt(square)))
            longest = min(longest, left * (BEYOND if left < d.touch.blind_step[c] else APPROACH))
    return longest
