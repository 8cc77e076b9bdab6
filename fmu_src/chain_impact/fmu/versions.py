"""The versions of the FMI standard for which FMUs are written, 2.0 and 3.0."""

from __future__ import annotations

FMI_2, FMI_3 = 2, 3
VERSIONS = (FMI_2, FMI_3)


def is_fmi_2(version: str | None) -> bool:
    """Return whether a model description is of FMI 2.0, by its attribute ``fmiVersion``."""
    return version == "2.0"
