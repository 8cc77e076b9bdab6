"""Makes one function of a list of functions: its first argument selects which of them is called."""


def dispatch(functions):
    """Make a function of (number, …) that calls the function with that number, from 0, on the rest."""
    first, others = functions[0], functions[1:]
    if not others:
        return lambda _number, *rest: first(*rest)
    after = dispatch(others)
    return lambda number, *rest: first(*rest) if number == 0 else after(number - 1, *rest)
