"""The scales of errors of the components of the state: the allowed error is the tolerance times the scale."""

from chain_impact.kernel.constraints.geometry import clearance_and_rate, largest_coordinate
from chain_impact.kernel.record.state import (
    FIRST_ANGLE,
    dissipated_at,
    omega_at,
    sundman_u_at,
    supplied_at,
    velocity_at,
)

# The largest allowed error of a penetration, relative to max(δ, δ*) in ``penetration_scale``, at tolerances
# up to this value. With more than some hundredths, a point that comes to rest would bounce again.
LARGEST_ERROR = 0.01
# POSITION_ROUND_OFF: the round-off of a position, relative to the larger of two lengths: the largest
# coordinate, and the largest angle times the longest link. For contacts that have lasted longer than
# AGE_AT_REST/ω, with the contact's frequency ω, POSITION_ROUND_OFF_AT_REST is used: in such a contact, a
# single step with more round-off than usual would excite a motion that short steps keep alive.
POSITION_ROUND_OFF, POSITION_ROUND_OFF_AT_REST, AGE_AT_REST = 1e-15, 4e-15, 1e3


def set_scales(d, y, scale, contact_count):
    """Set ``scale``, the scales of errors in state y: the allowed error is the tolerance times the scale.

    The scale of an angle is 1 rad, and that of a position is the length of the longest link, whatever their
    values are. The scale of a velocity component is its absolute value plus one longest link per second; that
    of an angular velocity is its absolute value plus 1 rad/s. The scale of the dissipated or supplied energy
    is its absolute value plus `chain.energy_scale` and ``impact_energy``. The supplied energy has a scale,
    and is controlled, only if motions of base, walls or belts are prescribed: the supplied power then changes
    with these motions, however slow the chain is. The power of other inputs depends only on components that
    are controlled.

    The scales of the clearances of the first ``contact_count`` active contacts (``penetration_scale``) are
    stored from the index of u on, as in z of extended_state.py. The points must be located for y.

    Other components have no scales, and their errors are not controlled: u and t, whose errors are far
    smaller than those of the motion, the rates of clearances, and the quadratures.
    """
    n, longest_link = d.link_count, d.chain.longest_link
    for j in range(velocity_at(n)):
        scale[j] = longest_link if j < FIRST_ANGLE else 1.0
    for j in range(velocity_at(n), dissipated_at(n)):
        scale[j] = (longest_link if j < omega_at(n) else 1.0) + abs(y[j])
    scale[dissipated_at(n)] = d.chain.energy_scale + abs(y[dissipated_at(n)]) + impact_energy(d)
    if d.channel_count > 0:
        scale[supplied_at(n)] = d.chain.energy_scale + abs(y[supplied_at(n)]) + impact_energy(d)
    for k in range(contact_count):
        scale[sundman_u_at(n) + k] = penetration_scale(d, d.contacts.active_index[k])


def raise_scales(d, y, scale, contact_count):
    """Raise the scales of ``set_scales`` where the tolerance would demand an error below the round-off.

    The round-off of positions excites, in each step, fast motions of a chain that rests on contacts. Shorter
    steps do not reduce these motions, but longer implicit steps damp them. A contact with the frequency ω =
    v₀/δ* (``penetration_scale``) turns a round-off ε of a position into a speed ω ε, so the scales of
    clearances, velocities and angular velocities are raised. The arguments are those of ``set_scales``.
    """
    n, longest_link, speed = d.link_count, d.chain.longest_link, 0.0
    if contact_count == 0:
        return
    round_off_length = largest_length(d, y) / d.solver.tolerance
    for k in range(contact_count):
        c = d.contacts.active_index[k]
        frequency = contact_frequency(d, c)
        is_at_rest = frequency * (d.step.end - d.contacts.onset[c]) > AGE_AT_REST
        round_off = round_off_length * (POSITION_ROUND_OFF_AT_REST if is_at_rest else POSITION_ROUND_OFF)
        scale[sundman_u_at(n) + k] = max(scale[sundman_u_at(n) + k], round_off)
        speed = max(speed, frequency * round_off)
    for j in range(velocity_at(n), dissipated_at(n)):
        scale[j] = max(scale[j], speed * (1.0 if j < omega_at(n) else 1.0 / longest_link))


def largest_length(d, y):
    """Return the length [m] to which the round-off of positions is relative: see POSITION_ROUND_OFF."""
    largest_angle = 0.0
    for i in range(d.link_count):
        largest_angle = max(largest_angle, abs(y[FIRST_ANGLE + i]))
    return max(largest_coordinate(d), d.chain.longest_link * largest_angle)


def contact_frequency(d, c):
    """Return ω = v₀/δ* [1/s] of active candidate c: its impact speed divided by its expected penetration."""
    return d.contacts.latched_speed[c] / d.contacts.expected_penetration[c]


def is_tolerance_below_round_off(d, y):
    """Return whether the round-off of positions in state y alone exceeds the error allowed to a velocity.

    In the contact with the largest frequency ω, the round-off ε of a position causes a speed ω ε; the allowed
    error is the tolerance times one longest link per second. The points must be located for y.
    """
    frequency = 0.0
    for k in range(d.contacts.force_law_count):
        frequency = max(frequency, contact_frequency(d, d.contacts.active_index[k]))
    allowed_speed = d.solver.tolerance * d.chain.longest_link
    return frequency * POSITION_ROUND_OFF_AT_REST * largest_length(d, y) > allowed_speed


def penetration_scale(d, c):
    """Return the scale [m] of errors in the clearance of active candidate c, for the located points.

    An error Δδ of the penetration soon causes an error of about ω Δδ in the speed, with ω ≈ v₀/δ*, the impact
    speed divided by the expected penetration. So Δδ may be as large as the tolerated error of a speed,
    divided by ω. The scale is max(δ, δ*); if v₀ is below s, one longest link per second, the scale is larger
    by a factor: s/v₀, or less, so that the factor raises no error above LARGEST_ERROR × max(δ, δ*).
    """
    clearance, _ = clearance_and_rate(d, c)
    penetration = max(d.contacts.expected_penetration[c], -clearance)
    factor = min(d.chain.longest_link / d.contacts.latched_speed[c], LARGEST_ERROR / d.solver.tolerance)
    return penetration * max(1.0, factor)


def impact_energy(d):
    """Return the sum of ½ m v₀² [J] over all active contacts, a scale of the energies of their impacts.

    m is the effective mass and v₀ the latched speed in the law of a contact.
    """
    energy = 0.0
    for k in range(d.contacts.active_count):
        c = d.contacts.active_index[k]
        speed = d.contacts.latched_speed[c]
        energy += 0.5 * d.contacts.effective_mass[c] * (speed * speed)
    return energy
