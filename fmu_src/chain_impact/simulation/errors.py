"""Errors of runs."""

from __future__ import annotations

from chain_impact.deprecated import OlderName
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.recording.recording import Recording
from chain_impact.results.result import Result


class RunError(RuntimeError):
    """Raised when a run cannot start or continue, in this process, in an FMU or on a cluster.

    Also raised when the window of ``--show`` cannot be opened.

    ``recording`` has the results up to the fault; it is None if there are none.
    """

    def __init__(self, message: str, recording: Recording | None = None) -> None:
        """Store the recording up to the fault, together with the message."""
        super().__init__(message)
        self.recording = recording


class SimulationError(RunError):
    """Raised when the solver cannot start or continue.

    Attributes:
        status: the code, see ``chain_impact.kernel.status``.
        time: the time at which the solver stopped [s]; 0 if the scene cannot start.
        part: the part of the scene that is the reason, such as a point and a wall; "" if no single part is.
        result: the ``Result`` up to this time; None if the scene cannot start, and for a
            ``Chain`` that keeps no rows.
        source: the name of the scene, with which the message begins; "" for none.
        fault: the rest of the message.
    """

    def __init__(
        self, status: int, time: float, result: Result | None, part: str = "", source: str = ""
    ) -> None:
        """Make the message from the status, the time and the part."""
        self.fault = f"the simulation stopped at t = {time:.9g} s: {fault_text(status, part)}"
        super().__init__(f"{source}: {self.fault}" if source else self.fault, result)
        self.status, self.time, self.result, self.part, self.source = status, time, result, part, source

    def __reduce__(self) -> tuple[type[SimulationError], tuple[int, float, Result | None, str, str]]:
        """Pickle the arguments, so that the error can return from another process."""
        return type(self), (self.status, self.time, self.result, self.part, self.source)

    place = OlderName("part")


def fault_text(status: int, part: str) -> str:
    """Return the sentence for a status, with the part of the scene that is the reason, if there is one."""
    return f"{STATUS_TEXT[status]}: {part}" if part else STATUS_TEXT[status]
