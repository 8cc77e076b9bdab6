"""Which functions the compiler has to inline."""


def inlined(function):
    """Mark a function that is compiled into its callers, so that the compiler knows its arguments there."""
    function.inlined = True
    return function
