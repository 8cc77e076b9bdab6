"""The root of a function between two bounds: a bracket that shrinks to round-off whatever the function is."""

# Guesses of a fast method, which needs three to ten. Then the bracket is halved.
FAST = 20
# Guesses after which no number is left within a bracket of width 1, or it is narrower than any resolution.
TRIES = FAST + 64


def next_guess(low, high, guess, tries):
    """The guess of a fast method, or the middle of the bracket if it lies outside or after FAST ``tries``."""
    if tries < FAST and low < guess < high:
        return guess
    return 0.5 * (low + high)
