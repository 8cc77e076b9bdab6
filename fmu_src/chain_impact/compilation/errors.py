"""What goes wrong when a kernel is made."""


class BuildError(RuntimeError):
    """The kernel could not be compiled, or the FMU is not valid; the message holds the compiler's own."""
