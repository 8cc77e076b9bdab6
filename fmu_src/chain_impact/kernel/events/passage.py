"""The first time in a step at which a function of the motion falls below zero, by samples."""

import math

from chain_impact.kernel.mathematics.root_search import MOST_GUESSES, next_guess

# A parabola through three samples shows a possible fall below zero if it is, at its vertex, below VERTEX_PART
# times the larger of the outer samples. With a smaller number, falls far from a parabola would be missed.
VERTEX_PART = 0.1
FINEST_RESOLUTION = 1e-15  # the finest resolution of ``make_passage_search``, as a fraction of a step


def make_passage_search(function, samples, resolution, finds_dips=False):
    """Return a function that searches a step for the first θ at which ``function`` falls below zero.

    Args:
        function: function of (d, c, θ), for candidate or element c at the fraction θ of the last step.
        samples: function of d that returns the number of equidistant samples, of which ``end`` is the last.
        resolution: accuracy of the location, in the step's integration variable [s].
        finds_dips: whether the vertex of the parabola through three samples is a further sample if the
            parabola is low enough there (VERTEX_PART). Otherwise falls between two samples are missed.

    Returns:
        A function of (d, c, end). It returns the first θ ≤ ``end`` at which ``function`` falls below zero: 0
        if it is below zero at 0 and at the next sample; −1 if it is below zero at no sample after 0.
    """

    def passage(d, c, end):
        count, low, at_low, at_before = samples(d), 0.0, math.nan, math.nan
        for sample in range(count + 1):
            high = end * sample / count
            value = function(d, c, high)
            start, at_start, stop, at_stop = low, at_low, high, value
            # the parabola through the last three samples has the vertex low − ½ slope/curvature (high − low),
            # and there the value at_low − slope²/(8 curvature)
            slope, curvature = value - at_before, at_before - 2.0 * at_low + value
            excess = at_low - VERTEX_PART * max(at_before, value)
            has_vertex = value >= 0.0 and abs(slope) < 2.0 * curvature
            if finds_dips and has_vertex and 8.0 * curvature * excess < slope * slope:
                if slope >= 0.0:
                    start, at_start = end * (sample - 2) / count, at_before
                stop = low - 0.5 * slope / curvature * (high - low)
                at_stop = function(d, c, stop)
            if at_stop < 0.0 < sample:
                return root(d, c, start, stop, at_start, at_stop)
            low, at_low, at_before = high, value, at_low
        return -1.0

    def root(d, c, low, high, at_low, at_high):
        # the rule of false position in the Illinois form (Dowell & Jarratt 1971, BIT 11:168)
        if at_low < 0.0:
            return low
        last, width = 0, max(FINEST_RESOLUTION, resolution / d.step.size)
        for tries in range(MOST_GUESSES):
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
