"""Operations on parts of the record, and marks for functions that the compiler treats specially.

Other functions of this module combine functions.
"""


def clear_numbers(part):
    """Set all numbers of a part of the record, also those of its subparts, to zero."""
    part.clear()


def copy_row(table, source, row):
    """Copy all columns of row ``source`` of a table of the record to the row with the index ``row``."""
    table[row] = table[source]


def inlined(function):
    """Mark a function that is always inlined into its callers, and return it.

    In each call, the compiler can then use what it knows about the arguments.
    """
    function.inlined = True
    return function


def has_dual_rule(function):
    """Mark a function that DUAL_RULES in tangent/rules.py replaces if an argument carries derivatives.

    Such an argument is a dual number or a tangent instance.
    """
    function.has_dual_rule = True
    return function


def has_complex_rule(function):
    """Mark a function that COMPLEX_RULES in chain/response.py replaces if an argument is complex."""
    function.has_complex_rule = True
    return function


def dispatch(functions):
    """Return a function of (number, …) that calls entry ``number`` of ``functions`` with the other arguments.

    The entries are counted from 0.
    """
    first, others = functions[0], functions[1:]
    if not others:
        return lambda _number, *arguments: first(*arguments)
    after = dispatch(others)
    return lambda number, *arguments: first(*arguments) if number == 0 else after(number - 1, *arguments)


def called_in_turn(first, *others):
    """Return a function that calls several functions, one after the other, with its own arguments.

    The returned function returns nothing. If ``first`` is the only function, the result is ``first``.
    """
    if not others:
        return first
    following = called_in_turn(*others)

    def both(d, h, *more):
        first(d, h, *more)
        following(d, h, *more)

    return both
