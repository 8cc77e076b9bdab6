"""Functions that combine functions."""


def dispatch_by_number(functions):
    """Return a function of (number, …) that calls entry ``number`` of ``functions`` with the other arguments.

    The entries are counted from 0.
    """
    first, others = functions[0], functions[1:]
    if not others:
        return lambda _number, *arguments: first(*arguments)
    after = dispatch_by_number(others)
    return lambda number, *arguments: first(*arguments) if number == 0 else after(number - 1, *arguments)


def join_functions(first, *others):
    """Return a function that calls several functions, one after the other, with its own arguments.

    The returned function has at least two arguments, the instance and a step size, and returns nothing. If
    ``first`` is the only function, the result is ``first``.
    """
    if not others:
        return first
    following = join_functions(*others)

    def call_all(d, h, *more):
        first(d, h, *more)
        following(d, h, *more)

    return call_all
