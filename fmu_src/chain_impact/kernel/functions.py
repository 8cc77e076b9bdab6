"""Functions that are compiled in a special way: they clear memory, are inlined, or combine others."""


def clear(part):
    """Set all numbers of a part of the record to zero."""
    part.clear()


def inlined(function):
    """Mark a function that is compiled into its callers, so that the compiler knows its arguments."""
    function.inlined = True
    return function


def dispatch(functions):
    """Make a function of (number, …) that calls one of several functions, by its number from 0."""
    first, others = functions[0], functions[1:]
    if not others:
        return lambda _number, *rest: first(*rest)
    after = dispatch(others)
    return lambda number, *rest: first(*rest) if number == 0 else after(number - 1, *rest)


def sequence(first, *others):
    """Return a function that calls several functions, which return nothing, in turn with its arguments."""
    if not others:
        return first
    rest = sequence(*others)

    def both(d, h, *more):
        first(d, h, *more)
        rest(d, h, *more)

    return both
