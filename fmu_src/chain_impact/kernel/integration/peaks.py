"""The maximum of a function of the state inside the last step."""


def maximum_of(value_at):
    """Return the function that finds a maximum of a value near a place in the last step.

    Args:
        value_at: function (d, index, θ) for the value at a fraction θ of the step.
    """

    def maximum_near(d, index, middle, reach, end):
        """The maximum near the fraction ``middle`` of the last step, before its fraction ``end``.

        Three parabolas, each through three points around the last top; returns the final top or a larger
        sample.

        Args:
            d: the instance.
            index: of a candidate or a joint.
            middle: where to begin …
            reach: … and how far around it.
            end: fraction of the step beyond which nothing counts.
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
            middle = min(max(middle, reach), end - reach)
        return max(best, summit)

    return maximum_near
