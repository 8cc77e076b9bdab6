"""Sites: additional points that are fixed to links, such as the heel of a foot or the corner of a brick.

A site lies at x along the line of its link, from the proximal joint, and at y to the left of the line. With
the vector L along the link and L⊥ = ẑ × L, the arm from the proximal joint to the site is

    r = (x/ℓ) L + (y/ℓ) L⊥,   ℓ the length of the link,

and p = p_i + r, v = v_i + ω r⊥, a = a_i + α r⊥ − ω² r. A force F at the site acts on the chain as F at the
proximal joint and the moment r⊥·F on the link. The sites are numbered in the order of their links. In arrays
of all places the sites come after the points and the joints. Without sites, the kernel computes none of these
terms.
"""

from chain_impact.kernel.function_marks import inlined


@inlined
def joint_place(d, i):
    """Return the index among all places of link i's proximal joint, i from 0; joints follow points 0…N."""
    return d.link_count + 1 + i


@inlined
def site_place(d, s):
    """Return the index of site s among all places: 2 N + 1 + s, after the points 0…N and N joints.

    The index is the same in a scene without stops and friction in joints, where the places of joints are not
    used.
    """
    return 2 * d.link_count + 1 + s


@inlined
def point_of_site(d, s):
    """Return the number of site s as a point: the sites come after the points 0…N."""
    return d.link_count + 1 + s


@inlined
def site_of_point(d, point):
    """Return the index s of the site whose number as a point is ``point``, which is > N."""
    return point - d.link_count - 1


@inlined
def site_arm(d, link_vectors, s):
    """Return x and y, in the world frame, of the arm r [m] of site s, from its link's proximal joint."""
    i, along, beside = d.site.link[s], d.site.along[s], d.site.beside[s]
    lx, ly = link_vectors.x[i], link_vectors.y[i]
    return along * lx - beside * ly, along * ly + beside * lx


def locate_sites(d, y, first, position, velocity):
    """Set positions and velocities of the sites, from known positions and velocities of the joints.

    The angular velocities of the links begin at index ``first`` of the state y.
    """
    for s in range(d.site_count):
        i, k = d.site.link[s], site_place(d, s)
        rx, ry = site_arm(d, d.scratch.link_vector, s)
        position.x[k], position.y[k] = position.x[i] + rx, position.y[i] + ry
    set_site_motions(d, d.scratch.link_vector, y, first, velocity)


def set_site_motions(d, link_vectors, turns, first, vectors):
    """Set in ``vectors`` the vectors of the sites, from those of the joints and from the links' rotations.

    The vectors are velocities, small motions, or accelerations without the part −ω² r. The rotations of the
    links, angular velocities, small angles or angular accelerations, begin at index ``first`` of ``turns``.
    """
    for s in range(d.site_count):
        i, k = d.site.link[s], site_place(d, s)
        rx, ry = site_arm(d, link_vectors, s)
        vectors.x[k] = vectors.x[i] - turns[first + i] * ry
        vectors.y[k] = vectors.y[i] + turns[first + i] * rx


def accelerate_sites(d, y, rate, first, acceleration):
    """Set the accelerations of the sites, from known accelerations of the joints.

    The angular velocities ω of the links begin at index ``first`` of the state y, their angular accelerations
    α at the same index of its ``rate``.
    """
    set_site_motions(d, d.scratch.link_vector, rate, first, acceleration)
    for s in range(d.site_count):
        k, omega = site_place(d, s), y[first + d.site.link[s]]
        rx, ry = site_arm(d, d.scratch.link_vector, s)
        acceleration.x[k] -= omega * omega * rx
        acceleration.y[k] -= omega * omega * ry


def clear_sites(d, vectors):
    """Set the vectors of all sites to zero."""
    for k in range(site_place(d, 0), site_place(d, d.site_count)):
        vectors.x[k], vectors.y[k] = 0.0, 0.0


def has_link_moments(d):
    """Return whether applied forces may include moments on links; else these moments are not read.

    Forces at sites, and forces on centres of mass beside the lines of links, cause such moments.
    """
    return d.site_count > 0 or d.skewed != 0


def clear_link_moments(d, applied_force):
    """Set the moments on links in ``applied_force`` to zero, if the scene may have any.

    The torques of drives are not among these moments: they are in ``scratch.moment``.
    """
    for i in range(d.link_count if has_link_moments(d) else 0):
        applied_force.link[i] = 0.0


def move_site_forces(d, link_vectors, applied_force):
    """Replace the force at each site by an equal force at its link's proximal joint and a moment on the link.

    The moments on all links are first set to zero (``clear_link_moments``). Afterwards the forces at the
    sites in ``applied_force`` are zero.
    """
    clear_link_moments(d, applied_force)
    for s in range(d.site_count):
        i, k = d.site.link[s], site_place(d, s)
        rx, ry = site_arm(d, link_vectors, s)
        applied_force.x[i] += applied_force.x[k]
        applied_force.y[i] += applied_force.y[k]
        # the moment r⊥·F of the force F at the arm r
        applied_force.link[i] += rx * applied_force.y[k] - ry * applied_force.x[k]
        applied_force.x[k], applied_force.y[k] = 0.0, 0.0
