"""One function for a list of functions, of which a number chooses."""


def dispatch(functions):
    """Make a function of (number, …) that calls the function of that number, from 0, with the rest."""
    first, others = functions[0], functions[1:]
    if not others:
        return lambda _number, *rest: first(*rest)
    after = dispatch(others)
    return lambda number, *rest: first(*rest) if number == 0 else after(number - 1, *rest)
