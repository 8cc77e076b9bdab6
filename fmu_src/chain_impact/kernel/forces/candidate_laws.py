"""The contact law of each candidate: walls may have their own materials, and stops have their own laws.

The law of a joint's stop is given in angles: it is a moment M for the angle φ beyond the stop. The kernel
treats the stop as a contact at the lever arm s, the longest link (geometry.py). The penetration of this
contact is δ = s φ, and its force is F = M/s. So a law M = K φⁿ becomes a force with the stiffness K/sⁿ⁺¹. The
minimum impact speed of the contact [m/s] is s times the minimum impact speed of the stop [rad/s].

Candidates have the same law if their parameters are given in the same place, such as the same wall
(``law_origin``). Of such candidates, the kernel sets the law of the first one, and the others copy it
(``law.same_as``).
"""

import math

from chain_impact.kernel.chain.inertia import given_or_derived
from chain_impact.kernel.constraints.geometry import is_at_joint_stop, is_at_stop
from chain_impact.kernel.forces import user_law
from chain_impact.kernel.forces.friction import choose_wall_friction
from chain_impact.kernel.forces.laws import (
    ANY_EXPONENT,
    APPROACH_ONLY,
    LAW_COUNT,
    LEAST_RESTITUTIONS,
    RATE_EXPONENTS,
    REQUIRED_EXPONENTS,
    damping_factor,
    is_rigid,
)
from chain_impact.kernel.mathematics.powers import power
from chain_impact.kernel.record.operations import copy_row
from chain_impact.kernel.status import (
    CANDIDATE_PART,
    EXPONENT_NOT_ALLOWED,
    FRICTION_WITH_RIGID_WALLS,
    OK,
    PARAMETER_OUT_OF_RANGE,
    RESTITUTION_NOT_ALLOWED,
    RIGID_WHILE_TOUCHING,
    STATIC_BELOW_SLIDING,
    UNKNOWN_LAW,
    refuse_part,
)

# The largest depth in a wall at which a point at the end of a step counts as not touching, relative to the
# longest link; at rigid walls this depth is 0. For K = 1e8 N/m^1.5, n = 3/2 and links of 1 m, a force of
# 1e-10 N is neglected; the round-off of positions is about 1e-15 m. Without this margin, the solver would
# search every step for an onset if a point slides along a wall at zero clearance.
HARMLESS_DEPTH = 1e-12
# results of ``law_origin`` for a law that does not belong to a wall
COMMON_LAW, JOINT_STOP_LAW, SLIDER_STOP_LAW = -1, -2, -3
USER_LAW = LAW_COUNT + 1  # number of the user's law, in a kernel that is linked with such a law


def start_laws(d):
    """Find which candidates have the same law, and set the laws of all candidates; return a status."""
    for c in range(d.candidate_count):
        first, source = 0, law_origin(d, c)
        while law_origin(d, first) != source:
            first += 1
        d.law.same_as[c] = first
    return update_laws(d)


def law_origin(d, c):
    """Return a number that tells where the law of candidate c is given.

    Returns:
        The index of the wall (``candidate.wall``) if this wall has any own value of its material; COMMON_LAW
        for another wall; JOINT_STOP_LAW for a stop in a joint; SLIDER_STOP_LAW for a stop of the slider.
    """
    if is_at_stop(d, c):
        return JOINT_STOP_LAW if is_at_joint_stop(d, c) else SLIDER_STOP_LAW
    wall = d.candidate.wall[c]
    walls = d.walls
    has_own_material = walls.stiffness[wall] > 0.0 or walls.restitution[wall] >= 0.0
    has_own_material = has_own_material or walls.friction[wall] >= 0.0 or walls.static_friction[wall] >= 0.0
    return wall if has_own_material else COMMON_LAW


def update_laws(d):
    """Set the laws of all candidates to the given parameters; return a status.

    If the status is not OK, the laws stay as they are.
    """
    status = check_laws(d)
    if status != OK:
        return status
    d.contact_settings.any_force_law, d.contact_settings.any_rigid, d.contact_settings.any_friction = 0, 0, 0
    d.stops.restitution = given_or_derived(d.given.stop_restitution, d.given.restitution)
    for c in range(d.candidate_count):
        first = d.law.same_as[c]
        if first == c:
            derive_damping(d, c)
            set_law_parameters(d, c)
            set_law_flags(d, c)
        else:
            copy_row(d.law, first, c)  # a copy is faster than setting the same law again
    return OK


def check_laws(d):
    """Check the given laws, and return a status.

    RIGID_WHILE_TOUCHING means that an active contact with a force law would get the law of rigid walls.
    """
    for c in range(d.candidate_count):
        status = check_law(d, c) if d.law.same_as[c] == c else OK
        if status != OK:
            return refuse_part(d, CANDIDATE_PART, c, status)
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        if is_rigid(given_law_number(d, c)):
            return refuse_part(d, CANDIDATE_PART, c, RIGID_WHILE_TOUCHING)
    return OK


def are_laws_in_use(d):
    """Return whether all candidates have their given laws; only parameters that a run can change count."""
    for c in range(d.candidate_count):
        if d.law.same_as[c] == c and not is_law_in_use(d, c):
            return False
    return True


def is_law_in_use(d, c):
    """Return whether candidate c has its given law, restitution, stiffness and coefficients of friction."""
    law, (sliding, static) = d.law, given_friction(d, c)
    has_same_friction = law.friction[c] == sliding and law.static_friction[c] == max(sliding, static)
    return is_damping_derived(d, c) and law.stiffness[c] == given_stiffness(d, c) and has_same_friction


def set_law_flags(d, c):
    """Set the flags in ``contact_settings`` for c's law: a force or a rigid wall, and dry friction."""
    if d.law.static_friction[c] > 0.0:
        d.contact_settings.any_friction = 1
    if d.law.rigid[c]:
        d.contact_settings.any_rigid = 1
    else:
        d.contact_settings.any_force_law = 1


def given_law_number(d, c):
    """Return the number, from 1, of the contact law that is given for candidate c.

    For a stop in a joint the number is `stops.law` if `stops.law` > 0; in all other cases it is `given.law`.
    """
    return d.stops.law if is_at_joint_stop(d, c) and d.stops.law > 0 else d.given.law


def given_stiffness(d, c):
    """Return the given stiffness K [N/mⁿ] of candidate c: that of its wall, else ``given.stiffness``.

    A stop of the slider has ``given.stiffness``. The stiffness of stops in joints, given in N·m/radⁿ, is
    converted to that of a contact at the lever arm.
    """
    if is_at_joint_stop(d, c):
        return d.given.stop_stiffness / power(d.chain.longest_link, d.stops.exponent + 1.0)
    if is_at_stop(d, c):
        return d.given.stiffness
    stiffness = d.walls.stiffness[d.candidate.wall[c]]
    return stiffness if stiffness > 0.0 else d.given.stiffness


def given_restitution(d, c):
    """Return the given restitution e of candidate c.

    This is the own restitution of the candidate's wall, or that of stops in joints, if given; else the common
    restitution, as for a stop of the slider.
    """
    if is_at_joint_stop(d, c):
        return given_or_derived(d.given.stop_restitution, d.given.restitution)
    if is_at_stop(d, c):
        return d.given.restitution
    restitution = d.walls.restitution[d.candidate.wall[c]]
    return restitution if restitution >= 0.0 else d.given.restitution


def given_friction(d, c):
    """Return the given coefficients of sliding and of static friction of candidate c.

    They are the wall's own coefficients or the common ones, by the rule of ``choose_wall_friction``: a static
    coefficient of 0 stands for one that equals the sliding coefficient. Both are 0 for a stop.
    """
    if is_at_stop(d, c):
        return 0.0, 0.0
    given, walls, wall = d.given, d.walls, d.candidate.wall[c]
    return choose_wall_friction(
        given.friction, given.static_friction, walls.friction[wall], walls.static_friction[wall]
    )


def law_exponent(d, c):
    """Return the exponent n given for candidate c: that of stops in joints, or the common one."""
    return d.stops.exponent if is_at_joint_stop(d, c) else d.contact_settings.exponent


def check_law(d, c):
    """Check candidate c's given law, and whether the given parameters suit the law; return a status."""
    number, restitution = given_law_number(d, c), given_restitution(d, c)
    if not 1 <= number <= LAW_COUNT + user_law.has_user_law():
        return UNKNOWN_LAW
    status = check_law_values(d, c)
    if status != OK:
        return status
    if is_rigid(number) and max(given_friction(d, c)) > 0.0:
        return FRICTION_WITH_RIGID_WALLS
    if number == USER_LAW:
        return OK
    if ANY_EXPONENT != REQUIRED_EXPONENTS[number - 1] != law_exponent(d, c):
        return EXPONENT_NOT_ALLOWED
    return OK if restitution >= LEAST_RESTITUTIONS[number - 1] else RESTITUTION_NOT_ALLOWED


def check_law_values(d, c):
    """Check restitution, stiffness and friction given for candidate c, under any law; return a status."""
    sliding, static = given_friction(d, c)
    are_in_range = 0.0 <= given_restitution(d, c) <= 1.0 and given_stiffness(d, c) > 0.0
    if not (are_in_range and sliding >= 0.0 and static >= 0.0 and math.isfinite(sliding + static)):
        return PARAMETER_OUT_OF_RANGE
    return STATIC_BELOW_SLIDING if 0.0 < static < sliding else OK


def is_damping_derived(d, c):
    """Return whether the constants of candidate c were derived from the given law.

    The constants depend on the law's number, restitution and exponent. A run keeps the constants of the run
    before it if these three are the same.
    """
    has_same_law = d.law.number[c] == given_law_number(d, c) and d.law.exponent[c] == law_exponent(d, c)
    return has_same_law and d.law.restitution[c] == given_restitution(d, c)


def derive_damping(d, c):
    """Derive the constants of the given law of candidate c, unless they are already derived.

    The constants are the factor f(e) for the restitution e, the exponent p in the damping force d δᵖ δ̇ at
    the penetration δ, whether the damping acts on approach only, and whether the wall is rigid.
    """
    if is_damping_derived(d, c):
        return
    law, number = d.law, given_law_number(d, c)
    law.rigid[c] = is_rigid(number)
    law.rate_exponent[c], law.approach_only[c], law.damping_factor[c] = law_exponent(d, c), 0, 0.0
    if number <= LAW_COUNT:
        if RATE_EXPONENTS[number - 1] != ANY_EXPONENT:
            law.rate_exponent[c] = RATE_EXPONENTS[number - 1]
        law.approach_only[c] = APPROACH_ONLY[number - 1]
        law.damping_factor[c] = damping_factor(number, given_restitution(d, c))


def set_law_parameters(d, c):
    """Set the parameters of candidate c's law to the given values.

    At a joint's stop, values for angles are converted to values for lengths at the lever arm.
    """
    law = d.law
    law.number[c], law.exponent[c] = given_law_number(d, c), law_exponent(d, c)
    law.stiffness[c], law.restitution[c] = given_stiffness(d, c), given_restitution(d, c)
    law.harmless_depth[c] = 0.0 if law.rigid[c] else HARMLESS_DEPTH * d.chain.longest_link
    law.minimum_impact_speed[c] = d.contact_settings.minimum_impact_speed
    law.friction[c], static = given_friction(d, c)
    law.static_friction[c] = max(law.friction[c], static)
    if is_at_joint_stop(d, c):
        law.minimum_impact_speed[c] = d.stops.minimum_impact_speed * d.chain.longest_link
