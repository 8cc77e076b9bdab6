"""Events found by sampling a step: where a function of the motion first falls below zero."""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.integration.dense import TRIES, interpolate, next_guess
from chain_impact.kernel.integration.last_step import SOLVER, ensure_dense
from chain_impact.kernel.work_limit import count_other_work

RESOLUTION = 1e-15  # fraction of a step: nothing is located better


def first_passage(function, samples, resolution):
    """Make the search for the first θ in a step at which a function of (d, c, θ) falls below zero.

    Args:
        function: the value for candidate or element c at the fraction θ of the last step.
        samples: number of samples of the step.
        resolution: [s of the step's variable], to which θ is located.

    Returns:
        A function of (d, c, end) that returns the θ ≤ ``end``, or −1 if no sample is below zero.
    """

    def passage(d, c, end):
        low = 0.0
        for sample in range(1, samples + 1):
            high = end * sample / samples
            value = function(d, c, high)
            if value < 0.0:
                return root(d, c, low, high, value)
            low = high
        return -1.0

    def root(d, c, low, high, at_high):
        # The rule of false position in its Illinois form (Dowell & Jarratt 1971, BIT 11:168).
        at_low, last, width = function(d, c, low), 0, max(RESOLUTION, resolution / d.step.size)
        if at_low < 0.0:
            return low
        for tries in range(TRIES):
            if high - low <= width:
                break
            theta = next_guess(low, high, high - at_high * (high - low) / (at_high - at_low), tries)
            value = function(d, c, theta)
            if value == 0.0:
                return theta
            if value < 0.0:
                high, at_high = theta, value
                at_low *= 0.5 if last > 0 else 1.0
                last = 1
            else:
                low, at_low = theta, value
                at_high *= 0.5 if last < 0 else 1.0
                last = -1
        return high

    return passage


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
