"""The maximum of a quantity, such as a contact force, within the last step, by parabolas through values."""

from chain_impact.kernel.ode.dense_output import event_fraction


def maximum_of(value_at):
    """Return a function that estimates the maximum of a quantity near a given fraction of the last step.

    Args:
        value_at: function (d, index, θ) that returns the quantity at the fraction θ of the last step.
    """

    def maximum_near(d, index, middle, reach, end):
        """Return the maximum of the quantity near the fraction ``middle`` of the last step, but at least 0.

        The search uses up to three parabolas, each through three values of the quantity. The second and the
        third parabola are centred at the maximum of the parabola before, but stay between ``event_fraction``
        and ``end``; each is a tenth as wide as the parabola before. The search ends at a parabola without a
        maximum. The result is the largest of all values and, after three parabolas, the maximum of the third
        parabola, if this maximum lies between the outer two values.

        Args:
            d: the instance.
            index: the index of a candidate or a joint.
            middle: fraction of the step at the middle of the first parabola.
            reach: half the width of the first parabola, as a fraction of the step. The caller ensures that
                ``middle`` ± ``reach`` lies between ``event_fraction``, the start of the step, and ``end``.
            end: fraction of the step after which no value is used.
        """
        best, summit = 0.0, 0.0
        for _ in range(3):
            left = value_at(d, index, middle - reach)
            top = value_at(d, index, middle)
            right = value_at(d, index, middle + reach)
            best = max(best, left, top, right)
            second_difference = left - 2.0 * top + right
            if second_difference >= 0.0:
                return best
            shift = 0.5 * (left - right) / second_difference
            summit = top - 0.25 * (left - right) * shift if abs(shift) <= 1.0 else top
            middle += shift * reach
            reach *= 0.1
            middle = min(max(middle, event_fraction(d) + reach), end - reach)
        return max(best, summit)

    return maximum_near
