"""Checks that a record from outside, such as a restored state of an FMU, is safe to compute with.

Checked is every number that the kernel uses as an index or as the number of iterations of a loop. Any other
number may be wrong: it leads to a fault status, never to an access outside the record.
"""

from chain_impact.kernel import hooks
from chain_impact.kernel.events.exclusion import FAR
from chain_impact.kernel.events.marks import NEIGHBOUR
from chain_impact.kernel.integration.last_step import SOLVER
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT, SOLVER_METHODS
from chain_impact.kernel.integration.sundman import NO_CONTACT
from chain_impact.kernel.laws.contact_laws import LAW_COUNT
from chain_impact.kernel.laws.user_law import present
from chain_impact.kernel.model.friction import NO_FRICTION
from chain_impact.kernel.model.geometry import WALLS
from chain_impact.kernel.model.inputs import DEGREE
from chain_impact.kernel.status import LAST_STATUS, OK


def sound(d):
    """1 if every index of the record is within bounds and the hooks find theirs valid, or 0.

    The caller must ensure that the sizes at the start of the record, such as the number of links, are right.
    """
    return 1 if within_bounds(d) and hooks.indices_valid(d) == 1 else 0


def within_bounds(d):
    """Whether every index of the record is within its bounds."""
    laws = LAW_COUNT + present()
    fits = within(d.model.middle, 0, d.links)
    fits = fits and within(d.step.regularized, NO_CONTACT, d.candidates - 1)
    fits = fits and within(d.solver.method, 1, len(SOLVER_METHODS)) and d.finished.count >= 0
    fits = fits and within(d.step.method, EXPLICIT, IMPLICIT)
    fits = fits and within(d.step.last_method, EXPLICIT, IMPLICIT)
    fits = fits and within(d.search.known, 0, FAR) and within(d.step.dense_for, 0, SOLVER)
    fits = fits and within(d.statistics.status, OK, LAST_STATUS)
    fits = fits and within(d.latest.kept, 0, len(d.latest.time))
    fits = fits and within(d.given.course.order, 0, DEGREE) and within(d.inputs.course.order, 0, DEGREE)
    fits = fits and within(d.touch.active_count, 0, d.candidates)
    fits = fits and within(d.touch.compliant_count, 0, d.touch.active_count)
    fits = fits and friction_within_bounds(d)
    fits = fits and within(d.quadrature.count, 0, len(d.quadrature.index))
    for k in range(len(d.quadrature.index)):
        fits = fits and within(d.quadrature.index[k], 0, len(d.quadrature.index) - 1)
    for c in range(d.candidates):
        fits = (
            fits
            and within(d.candidate.stop[c], -1, 1)
            # a stop is in a joint, and these are counted from 1
            and within(d.candidate.point[c], abs(d.candidate.stop[c]), d.links)
            and within(d.candidate.place[c], 0, 2 * d.links)
            # those of stops have the two numbers after those of walls
            and within(d.candidate.wall[c], 0, len(WALLS) + d.candidates - 1 + 2 * abs(d.candidate.stop[c]))
        )
        fits = fits and within(d.law.number[c], least_law(d), laws)
        fits = fits and within(d.law.same_as[c], 0, c)
        fits = fits and within(d.touch.number[c], 0, d.impact.count)
        fits = fits and within(d.touch.active_index[c], 0, d.candidates - 1)
        fits = fits and within(d.touch.active[c], 0, 1) and within(d.touch.event[c], 0, NEIGHBOUR)
    return fits


def friction_within_bounds(d):
    """Whether the indices and counts of dry friction are within their bounds."""
    own = d.friction
    fits = within(own.used, 0, min(1, d.elements)) and within(own.count, 0, d.elements)
    fits = fits and within(own.contact_count, 0, min(own.count, d.candidates))
    fits = fits and within(own.stuck_count, 0, own.count) and within(own.stuck_joints, 0, own.stuck_count)
    fits = fits and d.changes.count >= 0
    for e in range(d.elements):
        fits = fits and within(d.element.index[e], 0, d.elements - 1)
        fits = fits and within(d.element.stuck[e], 0, d.elements - 1)
        fits = fits and within(d.element.mode[e], -1, NO_FRICTION)
    return fits


def least_law(d):
    """The least number of a law: 0 before the start of a run and after a start that failed."""
    started = d.model.size != 0.0 and d.statistics.status == OK
    return 1 if started or d.touch.active_count > 0 else 0


def within(number, least, most):
    """Whether least ≤ number ≤ most."""
    return least <= number <= most
