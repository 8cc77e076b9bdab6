"""What is wrong with an FMU: a sentence, and its place."""

from __future__ import annotations

from dataclasses import dataclass

DESCRIPTION = "modelDescription.xml"
COMPLETE = "complete"
"""The last call in the report of a trial that is whole."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong with an FMU.

    Attributes:
        text: a sentence that says what.
        file: the file in the FMU that has it; empty if it is the FMU as a whole.
        variable: the name of the variable that it is about, if any.
        attribute: the attribute or element of the model description that it is about, if any.
    """

    text: str
    file: str = DESCRIPTION
    variable: str = ""
    attribute: str = ""

    def __str__(self) -> str:
        """Place and sentence in one line."""
        return ": ".join([part for part in (self.file, self.variable, self.attribute) if part] + [self.text])
