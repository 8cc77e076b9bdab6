"""The response of the chain to impulses at its contacts: a linear solver for implicit steps and rigid walls.

With J the gradients of the clearances of the active contacts, an impedance D = diag(D_k) at their points, and
the joints' resistance K = s C + s² S for a time s, with dampers C and springs S, it solves in O(N)

    (M + Jᵀ D J + K) Δ = Jᵀ p + K r,

where p are impulses along the normals and K r those in the joints. The impedances are added to the
articulated inertia at their points, and a joint with the resistance κ_i is one more term of the elimination
(chain/damped.py). No matrix is formed.
"""

from chain_impact.kernel.chain.damped import factorize_damped, solve_damped
from chain_impact.kernel.chain.kinematics import move_points, zero
from chain_impact.kernel.chain.recursion import factorize, no_impedance, solve
from chain_impact.kernel.model.geometry import add_along_normal, add_impedance, along_normal

# Relative to the mobility of all links as one mass. In a toggle position of a pinned chain the mobility of a
# point is 0, and its effective mass infinite; a million times the chain's mass behaves like that.
LEAST_MOBILITY = 1e-6


def factorize_contacts(d, links, impedance, factors):
    """Eliminate M + Jᵀ D J for ``solve_contacts``, with D_k [kg] of the active contacts, packed."""
    add_impedances(d, impedance)
    factorize(d, links, d.work.impedance, factors)


def factorize_contacts_damped(d, links, impedance, time):
    """As ``factorize_contacts``, with the joints' resistance for a ``time`` s [s]; sets ``work.damped``."""
    add_impedances(d, impedance)
    factorize_damped(d, links, d.work.impedance, time, d.work.damped)


def add_impedances(d, impedance):
    """Set the impedances of all points: D_k n nᵀ of the active contacts, else 0."""
    no_impedance(d.work.impedance)
    for k in range(d.touch.active_count):
        add_impedance(d, d.touch.active_index[k], d.work.impedance, impedance[k])


def solve_contacts(d, links, factors, impulse, change):
    """Find Δ for ``impulse`` p_k [N·s] of the active contacts, packed.

    Args:
        d: the instance.
        links: record with ``x, y``, shape (N+1,): the link vectors L_i [m] (entry N is not used).
        factors: those of ``factorize_contacts``.
        impulse: shape (C,), of which only the first ``active_count`` entries are used.
        change: result Δ of the coordinates' rates, shape (N+2,) [m/s, rad/s]. The resulting motion of the
            points is stored in ``work.motion``.
    """
    load_contacts(d, impulse)
    solve(d, links, factors, d.work.load, change)
    move_points(links, change, d.work.motion)


def solve_contacts_damped(d, links, impulse, change):
    """As ``solve_contacts``, with resisting joints, whose impulses are in ``work.damped.impulse``."""
    load_contacts(d, impulse)
    solve_damped(d, links, d.work.damped, d.work.load, d.work.damped.impulse, change)
    move_points(links, change, d.work.motion)


def load_contacts(d, impulse):
    """Set the loads on the points to the impulses of the active contacts along their normals."""
    zero(d.work.load)
    for k in range(d.touch.active_count):
        add_along_normal(d, d.touch.active_index[k], d.work.load, impulse[k])


def effective_mass(d, c):
    """Effective mass 1/(J M⁻¹ Jᵀ) [kg] of candidate c along its normal, at the located points."""
    work = d.work
    no_impedance(work.impedance)
    factorize(d, work.link, work.impedance, work.factors)
    zero(work.load)
    add_along_normal(d, c, work.load, 1.0)
    solve(d, work.link, work.factors, work.load, work.change)
    move_points(work.link, work.change, work.motion)
    # in a toggle position no impulse moves the point: its mobility is 0
    mobility = LEAST_MOBILITY * d.model.size * d.model.size / d.model.energy
    return 1.0 / max(mobility, along_normal(d, c, work.motion))
