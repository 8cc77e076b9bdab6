"""The maximum of a quantity within the last step, from its dense output."""

from chain_impact.kernel.ode.dense import event_fraction


def maximum_of(value_at):
    """Return a function that finds the maximum of a quantity near a given time in the last step.

    Args:
        value_at: function (d, index, θ) that returns the quantity at the fraction θ of the step.
    """

    def maximum_near(d, index, middle, reach, end):
        """Return the maximum of the quantity near the fraction ``middle`` of the last step.

        Values before ``event_fraction`` and after ``end`` do not count. ``event_fraction`` is 0, the start of
        the step; in a tangent instance it has derivatives.

        The search uses up to three parabolas, each through three points. The second and the third parabola
        lie around the maximum of the one before. If a parabola has no maximum, the search ends. The result is
        the largest of the values at all these points, the maximum of the third parabola, and 0.

        Args:
            d: the instance.
            index: the index of a candidate or a joint.
            middle: fraction of the step at which the search begins.
            reach: distance from ``middle`` that the search covers.
            end: fraction of the step beyond which values do not count.
        """
        best, summit = 0.0, 0.0
        for _ in range(3):
            left = value_at(d, index, middle - reach)
            top = value_at(d, index, middle)
            right = value_at(d, index, middle + reach)
            best = max(best, left, top, right)
            bend = left - 2.0 * top + right
            if bend >= 0.0:
                return best
            shift = 0.5 * (left - right) / bend
            summit = top - 0.25 * (left - right) * shift if abs(shift) <= 1.0 else top
            middle += shift * reach
            reach *= 0.1
            middle = min(max(middle, event_fraction(d) + reach), end - reach)
        return max(best, summit)

    return maximum_near
