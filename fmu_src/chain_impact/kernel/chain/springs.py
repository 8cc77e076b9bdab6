"""The torsional springs of the joints: each stores ½ k φ², φ = θ_i − θ_{i−1} − φ₀ from its rest angle φ₀.

The angles of links include full turns, and so does φ. The base of a pinned chain has θ₀ = 0; a free base has
no joint and no spring.
"""

from chain_impact.kernel.chain.state import ANGLES


def spring_stiffness(d, i):
    """k_i [N·m/rad], 0 at a free base, which has no joint."""
    return d.model.joint_stiffness[i] if i > 0 or d.model.pinned else 0.0


def resists(constant):
    """Whether this damping or stiffness of a joint has an effect, so that its terms are needed."""
    return constant != 0.0


def stretch(d, y, i):
    """φ_i [rad], the angle of the joint of link i relative to the rest angle of its spring."""
    before = y[ANGLES + i - 1] if i > 0 else 0.0
    return y[ANGLES + i] - before - d.model.joint_rest_angle[i]


def spring_energy(d, y):
    """The energy [J] stored in the springs."""
    energy = 0.0
    for i in range(d.links):
        angle = stretch(d, y, i)
        energy += 0.5 * spring_stiffness(d, i) * angle * angle
    return energy
