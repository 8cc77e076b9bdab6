"""Events that are looked for at samples of a step: where something first comes true."""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.last_step import SOLVER, ensure_dense

RESOLUTION = 1e-12  # s of the variable of the step, as that of onsets that are one event


def first_passage(comes_true, samples, root):
    """Make the search for the first place in a step at which a function of (d, c, θ) comes true.

    Args:
        comes_true: the function, for candidate c at the fraction θ of the last step.
        samples: places in the step to look at.
        root: function (d, c, low, high) that returns the θ where it comes true, between two samples.

    Returns:
        A function of (d, c, end) that returns the θ ≤ ``end``, or −1 when it is true at no sample.
    """

    def passage(d, c, end):
        low = 0.0
        for sample in range(1, samples + 1):
            high = end * sample / samples
            if comes_true(d, c, high):
                return root(d, c, low, high)
            low = high
        return -1.0

    return passage


def bisection(comes_true):
    """Make the root of ``first_passage`` for a function of (d, c, θ), by halving the interval."""

    def root(d, c, low, high):
        while (high - low) * d.step.size > RESOLUTION:
            middle = 0.5 * (low + high)
            if comes_true(d, c, middle):
                high = middle
            else:
                low = middle
        return high

    return root


def first_contact(suspected, passage):
    """Make the search for the active contact at which something comes true first.

    Args:
        suspected: function (d, c): whether it may. The points are located at the first θ found so far.
        passage: function (d, c, end) that returns the θ ≤ ``end`` where it does, or −1.

    Returns:
        A function of (d, end) that returns the candidate, or −1, and the θ, or ``end``, where the points are
        located then.
    """

    def search(d, end):
        found, first = -1, end
        for k in range(d.touch.active_count):
            c = d.touch.active_index[k]
            if suspected(d, c):
                theta = passage(d, c, first)
                if theta >= 0.0:
                    found, first = c, theta
                locate_at(d, first)
        return found, first

    return search


def locate_at(d, theta):
    """Set ``work.y`` to the state at the fraction θ of the step, and locate its points."""
    d.limits.other_work += 1
    if 0.0 < theta < 1.0:
        ensure_dense(d, SOLVER)
        interpolate(d.step, theta, d.work.y)
    else:
        for j in range(len(d.work.y)):
            d.work.y[j] = d.step.state[j] if theta == 0.0 else d.step.state_end[j]
    locate_points(d, d.work.y)
