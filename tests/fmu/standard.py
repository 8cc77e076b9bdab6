"""The header files of the FMI standard, which fmpy contains."""

import re
from pathlib import Path

import fmpy

HEADERS = Path(fmpy.__file__).with_name("c-code")


def co_simulation_functions() -> list[str]:
    """Return the names of all functions of an FMU for co-simulation (FMI 2.0.5, section 2.3)."""
    text = (HEADERS / "fmi2FunctionTypes.h").read_text(encoding="utf-8")
    begin, end = (
        "Types for Functions for FMI2 for Model Exchange",
        "Types for Functions for FMI2 for Co-Simulation",
    )
    text = text[: text.index(begin)] + text[text.index(end) :]
    return re.findall(r"\b(fmi2\w+)TYPE\b", text[text.index("Types for Common Functions") :])


def all_functions_of_fmi3() -> list[str]:
    """Return the names of all functions of FMI 3.0, which every FMU must have (3.0.2, section 2.5)."""
    text = (HEADERS / "fmi3FunctionTypes.h").read_text(encoding="utf-8")
    return re.findall(r"\b(fmi3\w+)TYPE\b", text)
