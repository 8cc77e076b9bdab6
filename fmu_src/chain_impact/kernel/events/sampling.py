"""The locator of events: where a function of the motion falls below zero within a step."""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.integration.dense import TRIES, interpolate, next_guess
from chain_impact.kernel.integration.last_step import SOLVER, ensure_dense
from chain_impact.kernel.work_limit import count_other_work

RESOLUTION = 1e-15  # fraction of a step: nothing is located better
# s. Events closer in time than this are one event: symmetric chains touch at several points at once.
SIMULTANEOUS = 1e-12


def locator(function):
    """Make the locator of a root of a function of (d, c, θ), for candidate or element c.

    Returns:
        A function of (d, c, low, high, at_low, at_high, resolution): the bounds of θ, the values there, the
        second one negative, and the resolution [s of the step's variable]. It returns θ; ``low`` if the
        function is negative there, too.
    """

    def locate(d, c, low, high, at_low, at_high, resolution):
        # The rule of false position as modified by Anderson & Björck (1973, BIT 13:253), with a factor of at
        # least that of the Illinois form. Guesses keep half the resolution from both bounds: so the last ones
        # close the bracket.
        last, width = 0, max(RESOLUTION, resolution / d.step.size)
        if at_low < 0.0:
            return low
        for tries in range(TRIES):
            if high - low <= width:
                break
            guess = high - at_high * (high - low) / (at_high - at_low)
            guess = min(max(guess, low + 0.5 * width), high - 0.5 * width)
            theta = next_guess(low, high, guess, tries)
            value = function(d, c, theta)
            if value == 0.0:
                return theta
            if value < 0.0:
                at_low *= max(0.5, 1.0 - value / at_high) if last > 0 else 1.0
                high, at_high, last = theta, value, 1
            else:
                at_high *= max(0.5, 1.0 - value / at_low) if last < 0 else 1.0
                low, at_low, last = theta, value, -1
        return high

    return locate


def first_passage(function, samples, resolution):
    """Make the search for the first θ in a step at which a function of (d, c, θ) falls below zero.

    Args:
        function: the value for candidate or element c at the fraction θ of the last step.
        samples: number of samples of the step.
        resolution: [s of the step's variable], to which θ is located.

    Returns:
        A function of (d, c, end) that returns the θ ≤ ``end``, or −1 if no sample is below zero.
    """
    locate = locator(function)

    def passage(d, c, end):
        low = 0.0
        for sample in range(1, samples + 1):
            high = end * sample / samples
            value = function(d, c, high)
            if value < 0.0:
                return locate(d, c, low, high, function(d, c, low), value, resolution)
            low = high
        return -1.0

    return passage


def locate_at(d, theta):
    """Set ``work.y`` to the state at the fraction θ of the step, and locate its points."""
    count_other_work(d, 1)
    if theta in (0.0, 1.0):
        for j in range(len(d.work.y)):
            d.work.y[j] = d.step.state[j] if theta == 0.0 else d.step.state_end[j]
    else:
        ensure_dense(d, SOLVER)
        interpolate(d.step, theta, d.work.y)
    locate_points(d, d.work.y)
