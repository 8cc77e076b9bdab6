"""The error that is raised when a kernel or an FMU cannot be made."""


class BuildError(RuntimeError):
    """Raised when a kernel or an FMU cannot be made, or when an FMU is not valid.

    If a compiler fails, the error contains the compiler's message.
    """
