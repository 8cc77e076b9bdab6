"""The error that is raised when a kernel cannot be made."""


class BuildError(RuntimeError):
    """Raised when the kernel cannot be compiled, or the FMU is not valid.

    The message contains the compiler's message.
    """
