"""Events that are looked for at samples of a step: where something first comes true, by bisection."""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.last_step import SOLVER, complete

RESOLUTION = 1e-12  # s of the variable of the step, as that of onsets that are one event


def first_passage(comes_true, samples):
    """Make the search for the first place in a step at which a function of (d, c, θ) comes true.

    Args:
        comes_true: the function, for candidate c at the fraction θ of the last step.
        samples: places in the step to look at.

    Returns:
        A function of (d, c, end) that returns the θ ≤ ``end``, or −1 when it is true at no sample.
    """

    def passage(d, c, end):
        low = 0.0
        for sample in range(1, samples + 1):
            high = end * sample / samples
            if comes_true(d, c, high):
                while (high - low) * d.step.size > RESOLUTION:
                    middle = 0.5 * (low + high)
                    if comes_true(d, c, middle):
                        high = middle
                    else:
                        low = middle
                return high
            low = high
        return -1.0

    return passage


def locate_at(d, theta):
    """Set ``work.y`` to the state at the fraction θ of the step, and locate its points."""
    d.limits.other_work += 1
    if 0.0 < theta < 1.0:
        complete(d, SOLVER)
        interpolate(d.step, theta, d.work.y)
    else:
        for j in range(len(d.work.y)):
            d.work.y[j] = d.step.state[j] if theta == 0.0 else d.step.state_end[j]
    locate_points(d, d.work.y)
