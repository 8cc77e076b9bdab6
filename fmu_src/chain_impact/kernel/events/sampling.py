"""Events found by sampling a step: where a condition first becomes true."""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.last_step import SOLVER, ensure_dense
from chain_impact.kernel.work_limit import count_other_work

RESOLUTION = 1e-12  # s of the step's variable, the same as the interval in which onsets are one event


def first_passage(comes_true, samples, root):
    """Make the search for the first θ in a step at which a condition, a function of (d, c, θ), becomes true.

    Args:
        comes_true: the condition, for candidate c at the fraction θ of the last step.
        samples: number of samples of the step.
        root: function (d, c, low, high) that returns the θ where it becomes true, between two samples.

    Returns:
        A function of (d, c, end) that returns the θ ≤ ``end``, or −1 if the condition is true at no sample.
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
    """Make the ``root`` of ``first_passage`` for a condition, a function of (d, c, θ), by bisection."""

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
    """Make the search for the active contact with a force law for which a condition becomes true first.

    Args:
        suspected: function (d, c): whether it may become true; the points are at the first θ found so far.
        passage: function (d, c, end) that returns the θ ≤ ``end`` where it becomes true, or −1.

    Returns:
        A function of (d, end) that returns the candidate and its θ, or −1 and ``end``; the points are then
        located at that θ.
    """

    def search(d, end):
        found, first = -1, end
        for k in range(d.touch.compliant_count):
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
    count_other_work(d, 1)
    if 0.0 < theta < 1.0:
        ensure_dense(d, SOLVER)
        interpolate(d.step, theta, d.work.y)
    else:
        for j in range(len(d.work.y)):
            d.work.y[j] = d.step.state[j] if theta == 0.0 else d.step.state_end[j]
    locate_points(d, d.work.y)
