"""Marks for functions that the compiler treats specially."""


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
    """Mark a function that COMPLEX_RULES (chain/mass_matrix_solver.py) replaces if an argument is complex."""
    function.has_complex_rule = True
    return function
