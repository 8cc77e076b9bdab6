"""The guesses of a search for the root of a function in an interval that contains it."""

# The number of guesses of a fast method for a root, such as Newton's, in an interval that contains the root;
# three to ten guesses usually suffice. After FAST_GUESSES guesses each further guess halves the interval.
FAST_GUESSES = 20
# The largest number of guesses for a root: 64 halvings make an interval of length 1 shorter than 1e-19, or
# leave no floating-point number inside it.
MOST_GUESSES = FAST_GUESSES + 64


def next_guess(low, high, guess, tries):
    """Return ``guess`` if it lies between ``low`` and ``high``, else the middle of this interval.

    ``tries`` is the number of earlier calls in the search. From FAST_GUESSES on, the function always returns
    the middle, so that the search ends also where the fast method of the guesses fails.
    """
    if tries < FAST_GUESSES and low < guess < high:
        return guess
    return 0.5 * (low + high)
