"""The usual magnitudes of outputs."""

from __future__ import annotations

from chain_impact.kernel.forces.lossless_contact import lossless_penetration
from chain_impact.scene.scene import Scene


def nominal_values(scene: Scene) -> dict[str, float]:
    """Return name of a magnitude → its usual value, for FMI's attribute ``nominal`` of outputs.

    The names are those in ``VariableKind.nominal``, such as "energy".

    Let L be the length of the longest link, M the mass of all links, and v = L / 1 s. The motion has the
    magnitudes L, v, the energy M v², the momentum M v, the angular momentum M v L, the inertial force M v / 1
    s and the inertial moment M v L / 1 s. L is also the solver's scale ``longest_link``, and M v² its
    ``energy_scale`` in a chain without slider and rotors. Magnitudes of contacts are those of an impact of
    the mass M at v without damping, whose penetration δ obeys K δⁿ⁺¹/(n+1) = M v²/2 with stiffness K and
    exponent n. Magnitudes of stops follow in the same way from an impact of M at the distance L from the
    joint, at 1 rad/s; without stops of joints, they are missing.
    """
    links, contact, stops = scene.chain.links, scene.contact, scene.stops
    size, mass = max(link.length for link in links), sum(link.mass for link in links)
    energy = mass * size * size
    depth = lossless_penetration(0.5 * energy, contact.stiffness, contact.exponent)
    force = contact.stiffness * depth**contact.exponent
    scales = {"size": size, "energy": energy, "momentum": mass * size, "angular_momentum": energy}
    scales |= {"inertial_force": mass * size, "inertial_moment": energy, "depth": depth, "force": force}
    if stops.stiffness is not None and stops.exponent is not None:
        depth = lossless_penetration(0.5 * energy, stops.stiffness, stops.exponent)
        scales |= {"stop_depth": depth, "stop_moment": stops.stiffness * depth**stops.exponent}
    return scales
