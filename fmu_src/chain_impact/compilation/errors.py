"""The error that is raised when a kernel cannot be made."""


class BuildError(RuntimeError):
    """The kernel could not be compiled, or the FMU is not valid.

    The message holds the compiler's own message.
    """
