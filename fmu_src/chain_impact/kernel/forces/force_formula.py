"""The force of a contact, F = max(0, K δⁿ + d δᵖ δ̇), its partial derivatives and its elastic energy.

K is the stiffness, δ the penetration and δ̇ its rate. The damping d is latched: it is computed at the onset
and then fixed, unless ``relatch_speed`` or a change of the law computes it again. The laws with a force
in laws.py differ only in d, in the exponents n and p, and in whether they damp on approach only. A user's law
(user_law.py) has a formula of its own in place of K δⁿ + d δᵖ δ̇.

The force has a kink. For a law that damps on approach only, the kink lies at δ̇ = 0; for any other law, it
lies where the cut at 0 begins or ends. A step across a kink would lose its order of accuracy. So a step uses
the smooth formula of one side of the kink, even where the contact is on the other side;
``contacts.beyond_kink`` tells which formula. If the contact crosses the kink in a step, the step is repeated
to end there (events/force_events.py). Outputs and peaks use the true force.
"""

import math

from chain_impact.kernel.constraints.geometry import is_at_joint_stop, lever_of_candidate
from chain_impact.kernel.forces import user_law
from chain_impact.kernel.forces.candidate_laws import USER_LAW
from chain_impact.kernel.forces.laws import LAW_COUNT, MASS_POWERS
from chain_impact.kernel.function_marks import has_dual_rule, inlined
from chain_impact.kernel.mathematics.powers import power

# The increment of the central differences for the slopes of a user's law: relative to the penetration, or for
# its rate relative to the size of this rate plus the latched speed. The value is about the cube root of
# round-off, with which truncation and round-off cause equal errors.
RELATIVE_INCREMENT = 1e-5
# If a law damps on approach only, a step may use the force of the wrong side of δ̇ = 0, with the rate δ̇ of
# the penetration, while |δ̇| is at most TURNING_RATE times v₀ √(tolerance/max(1, damping_over_elastic)), with
# the latched speed v₀, plus a margin for a contact at rest (``turning_margin``). Without this margin, the
# wrong force changes the impulse by at most a tenth of the tolerance, relative to the impulse.
TURNING_RATE = 0.3


@has_dual_rule
def power_of_penetration(penetration, exponent):
    """Return δ^exponent, for a penetration δ ≥ 0, by roots and products for the exponents 0, ½, 1 and 3/2.

    Powers with any other exponent are those of ``power_by_roots``.
    """
    if exponent == 1.5:
        return penetration * math.sqrt(penetration)
    if exponent == 1.0:
        return penetration
    if exponent == 0.0:
        return 1.0
    if exponent == 0.5:
        return math.sqrt(penetration)
    return power_by_roots(penetration, exponent)


def power_by_roots(penetration, exponent):
    """Return δ^exponent, for a penetration δ ≥ 0, by roots and products for the exponents ¼, 2 and 5/2.

    Powers with any other exponent are those of ``power``.
    """
    if exponent == 0.25:
        return math.sqrt(math.sqrt(penetration))
    if exponent == 2.0:
        return penetration * penetration
    if exponent == 2.5:
        return penetration * penetration * math.sqrt(penetration)
    return power(penetration, exponent)


def elastic_force(d, c, penetration):
    """Return the elastic force K δⁿ [N] of candidate c, with stiffness K, for a penetration δ ≥ 0 [m]."""
    return d.law.stiffness[c] * power_of_penetration(penetration, d.law.exponent[c])


def elastic_energy(d, c, penetration):
    """Return the elastic energy K δⁿ⁺¹/(n+1) [J] of candidate c for a penetration δ ≥ 0 [m]."""
    return elastic_force(d, c, penetration) * penetration / (d.law.exponent[c] + 1.0)


def elastic_penetration(d, c, mass, speed):
    """Return the penetration [m] with elastic energy ½ m v², for ``mass`` m [kg] and ``speed`` v [m/s]."""
    stiffness, exponent = d.law.stiffness[c], d.law.exponent[c]
    # the elastic energy equals the kinetic energy: K δⁿ⁺¹/(n+1) = ½ m v²
    energy = 0.5 * mass * speed * speed
    return power(energy * (exponent + 1.0) / stiffness, 1.0 / (exponent + 1.0))


def set_expected_penetration(d, c):
    """Set the expected penetration [m] of candidate c, from latched speed and effective mass of its contact.

    A rigid wall has no penetration; for a candidate at a rigid wall the length of the longest link is set.
    """
    contacts = d.contacts
    if d.law.rigid[c]:
        contacts.expected_penetration[c] = d.chain.longest_link
    else:
        contacts.expected_penetration[c] = elastic_penetration(
            d, c, contacts.effective_mass[c], contacts.latched_speed[c]
        )


def set_damping(d, c):
    """Set the damping d [N·s/m^(p+1)] of candidate c, from latched speed and effective mass of its contact.

    p is the exponent of the penetration δ in the damping force. The function also sets
    ``contacts.kink_margin``: the |δ̇| up to which a law that damps on approach only may be on the wrong side
    of its kink; 0 for other laws.
    """
    law, contacts, number = d.law, d.contacts, d.law.number[c]
    factor, stiffness = law.damping_factor[c], law.stiffness[c]
    mass_power = MASS_POWERS[number - 1] if number <= LAW_COUNT else 0.0
    if mass_power == 0.0:
        # the damping d = λ K/v₀ of the Hunt–Crossley family, with factor λ, stiffness K and latched speed v₀
        contacts.damping[c] = factor * stiffness / contacts.latched_speed[c]
    else:
        # damping d = f K^(1−s) m^s × ``unit_of_damping``, with the law's factor f and exponent s,
        # stiffness K and effective mass m
        ratio = contacts.effective_mass[c] / stiffness
        factor_of_mass = power(ratio, mass_power)
        contacts.damping[c] = factor * stiffness * factor_of_mass * unit_of_damping(d, c, mass_power)
    contacts.kink_margin[c] = turning_margin(d, c) if law.approach_only[c] else 0.0


def unit_of_damping(d, c, mass_power):
    """Return the factor by which f K^(1−s) m^s is multiplied to give the damping d of candidate c.

    f and s = ``mass_power`` belong to the law (laws.py); n and p are the exponents of δ in its spring and in
    its damping. K is the stiffness and m the effective mass of the contact. The factor is 1 for all
    candidates except the stops of joints.

    At a joint's stop the law holds for angles: its damping is d' = f K'^(1−s) m'^s with the stiffness
    K' = K rⁿ⁺¹ and the moment of inertia m' = m r², where r is the lever arm. The kernel uses lengths at the
    lever arm, for which the damping is d = d'/rᵖ⁺². So the factor is a power of r; it is 1 if f has no unit.
    """
    if not is_at_joint_stop(d, c):
        return 1.0
    law = d.law
    lengths = (law.exponent[c] + 1.0) * (1.0 - mass_power) + 2.0 * mass_power - law.rate_exponent[c] - 2.0
    return power(lever_of_candidate(d, c), lengths)


def turning_margin(d, c):
    """Return the largest |δ̇| [m/s] at which a step may use the force of the wrong side of the kink δ̇ = 0.

    If |δ̇| reaches the speed v on the wrong side, the impulse of the contact has a relative error: (v/v₀)²
    times the result of ``damping_over_elastic``, with the latched speed v₀. TURNING_RATE limits this error.
    In a contact without motion, errors change the sign of δ̇ again and again; therefore the tolerance times
    one longest link per second is added to the result.
    """
    tolerance = d.solver.tolerance
    relative_speed = math.sqrt(tolerance / max(1.0, damping_over_elastic(d, c)))
    return TURNING_RATE * relative_speed * d.contacts.latched_speed[c] + tolerance * d.chain.longest_link


def law_force(d, c, penetration, rate):
    """Return the force ≥ 0 [N] of candidate c and the elastic part K δⁿ [N], at a penetration δ ≥ 0 [m].

    ``rate`` is δ̇ [m/s], the rate of the penetration; for δ̇ < 0 a law that damps on approach only does not
    damp.
    """
    force, elastic = uncut_force(d, c, penetration, rate, rate < 0.0)
    # max() is not used, because it could hide a NaN
    return 0.0 if force < 0.0 else force, elastic


def continued_force(d, c, penetration, rate):
    """Return force and elastic part [N] as ``law_force``, but by one side's formula on both sides of a kink.

    ``contacts.beyond_kink`` of candidate c tells which side's formula is used. If the contact is on the other
    side by more than a margin, the function sets ``contacts.kink_crossed``, so that the step is repeated to
    end at the kink.
    """
    is_beyond_kink = d.contacts.beyond_kink[c] != 0
    force, elastic = uncut_force(d, c, penetration, rate, is_beyond_kink)
    is_approach_only = d.law.approach_only[c] != 0
    note_crossing(d, c, rate if is_approach_only else force)
    return 0.0 if is_beyond_kink and not is_approach_only else force, elastic


def force_on_side(d, c, penetration, rate):
    """Return the true force ≥ 0 [N] of candidate c at a ``penetration`` [m] with a ``rate`` [m/s].

    For a law that damps on approach only, ``contacts.beyond_kink`` tells whether the damping acts. The sign
    of the rate δ̇ cannot tell this, because δ̇ is 0 up to errors in a contact without motion.
    """
    moves_outward = d.contacts.beyond_kink[c] != 0 if d.law.approach_only[c] else rate < 0.0
    force, _ = uncut_force(d, c, penetration, rate, moves_outward)
    return 0.0 if force < 0.0 else force


def note_crossing(d, c, height):
    """Record that candidate c has crossed its kink, if ``height`` is across it by more than ``kink_margin``.

    ``height`` is the result of ``height_over_kink``; ``contacts.beyond_kink`` tells the side before a
    crossing.
    """
    margin = d.contacts.kink_margin[c]
    if height > margin if d.contacts.beyond_kink[c] else height < -margin:
        d.contacts.kink_crossed[c] = 1


def clear_crossings(d):
    """Set ``contacts.kink_crossed`` of all active contacts to 0: no kink has been crossed yet in the step."""
    for k in range(d.contacts.active_count):
        d.contacts.kink_crossed[d.contacts.active_index[k]] = 0


def height_over_kink(d, c, penetration, rate):
    """Return a value of candidate c that is 0 at the kink of its force, and negative beyond the kink.

    For a law that damps on approach only the value is ``rate``, δ̇ [m/s]. For any other law it is the force
    [N] before the cut at 0, at the ``penetration`` [m] and this rate.
    """
    if d.law.approach_only[c]:
        return rate
    force, _ = uncut_force(d, c, penetration, rate, False)
    return force


def is_cut_off(d, c):
    """Return whether a step uses the force 0 for candidate c, because the contact is beyond the cut at 0."""
    return d.contacts.beyond_kink[c] != 0 and not d.law.approach_only[c]


@inlined
def uncut_force(d, c, penetration, rate, moves_outward):
    """Return force and elastic part [N] as ``law_force`` does, but without the cut at 0.

    ``moves_outward``: whether a law that damps on approach only has no damping, because the point moves
    outward.
    """
    spring = power_of_penetration(penetration, d.law.exponent[c])
    elastic = d.law.stiffness[c] * spring
    if d.law.number[c] == USER_LAW and user_law.has_user_law():
        return user_contact_force(d, c, penetration, rate), elastic
    return elastic + damping_slope(d, c, penetration, moves_outward, spring) * rate, elastic


def user_contact_force(d, c, penetration, rate):
    """Return the force [N] of a user's law for candidate c, before the cut at 0.

    The law of a joint's stop takes angles and returns a moment; the function converts ``penetration`` and
    ``rate`` to angles, and the moment to a force.
    """
    law, arm = d.law, lever_of_candidate(d, c)
    speed, mass = d.contacts.latched_speed[c] / arm, d.contacts.effective_mass[c] * arm * arm
    stiffness = law.stiffness[c]
    if is_at_joint_stop(d, c):
        stiffness *= power(arm, law.exponent[c] + 1.0)
    force = user_force(
        penetration / arm, rate / arm, speed, mass, stiffness, law.exponent[c], law.restitution[c]
    )
    return force / arm


@has_dual_rule
def user_force(penetration, rate, speed, mass, stiffness, exponent, restitution):
    """Return the force [N] of a user's law before the cut at 0.

    For a joint's stop the function returns the moment [N·m].
    """
    return user_law.force(penetration, rate, speed, mass, stiffness, exponent, restitution)


def force_may_jump(d, c):
    """Return whether the force of candidate c may jump where its contact begins or ends.

    This is possible for a user's law, and for a damping d δᵖ δ̇ with the exponent p = 0.
    """
    return d.law.number[c] == USER_LAW or d.law.rate_exponent[c] == 0.0


def damping_slope(d, c, penetration, moves_outward, spring):
    """Return the slope ∂F/∂δ̇ = d δᵖ [N·s/m] of candidate c, before F is cut off at 0; ``spring`` is δⁿ.

    F is the contact force, δ the ``penetration``, d the damping. The result is 0 if the point moves
    outward (``moves_outward``) and the law damps on approach only.
    """
    law = d.law
    if law.approach_only[c] and moves_outward:
        return 0.0
    has_same_exponent = law.rate_exponent[c] == law.exponent[c]
    return d.contacts.damping[c] * (
        spring if has_same_exponent else power_of_penetration(penetration, law.rate_exponent[c])
    )


def law_slopes(d, c, penetration, rate):
    """Return ∂F/∂δ [N/m] and ∂F/∂δ̇ [N·s/m] of candidate c at a penetration δ ≥ 0 [m] and its rate.

    Both are 0 if a step uses the force 0 (``is_cut_off``). At δ = 0, and instead of ∂F/∂δ < 0, ∂F/∂δ is 0.
    """
    if is_cut_off(d, c):
        return 0.0, 0.0
    if d.law.number[c] == USER_LAW and user_law.has_user_law():
        return user_slopes(d, c, penetration, rate)
    exponent = d.law.exponent[c]
    is_beyond_kink = d.contacts.beyond_kink[c] != 0
    force, elastic = uncut_force(d, c, penetration, rate, is_beyond_kink)
    damping = damping_slope(d, c, penetration, is_beyond_kink, power_of_penetration(penetration, exponent))
    # ∂F/∂δ = (n K δⁿ + p d δᵖ δ̇)/δ for the force F and the penetration δ. For n ≥ p and F ≥ 0 this is at
    # least (n−p) K δⁿ⁻¹, but near the kink F and the slope may be < 0. Such a slope is replaced by 0.
    stiffness = exponent * elastic + d.law.rate_exponent[c] * (force - elastic)
    return max(0.0, stiffness / penetration) if penetration > 0.0 else 0.0, damping


def user_slopes(d, c, penetration, rate):
    """Return the slopes of ``law_slopes`` for a user's law, by central differences of the force cut off at 0.

    A negative slope counts as 0, as does ∂F/∂δ at δ = 0.
    """
    step = RELATIVE_INCREMENT * penetration
    low_force, _ = law_force(d, c, penetration - step, rate)
    high_force, _ = law_force(d, c, penetration + step, rate)
    stiffness = (high_force - low_force) / (2.0 * step) if step > 0.0 else 0.0
    step = RELATIVE_INCREMENT * (abs(rate) + d.contacts.latched_speed[c])
    low_force, _ = law_force(d, c, penetration, rate - step)
    high_force, _ = law_force(d, c, penetration, rate + step)
    return max(0.0, stiffness), max(0.0, (high_force - low_force) / (2.0 * step))


def damping_over_elastic(d, c):
    """Return the damping force of candidate c divided by the elastic force K δⁿ, but at least 0.

    Both forces are those at the latched speed v₀ and the expected penetration; the damping force is the
    whole force minus K δⁿ. For the Hunt–Crossley family the result is the damping factor λ of the law.
    """
    force, elastic = law_force(d, c, d.contacts.expected_penetration[c], d.contacts.latched_speed[c])
    return max(0.0, force / elastic - 1.0)
