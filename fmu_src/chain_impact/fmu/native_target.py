"""A native FMU: the kernel's library is its binary, a table tells the C interface in it of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from chain_impact import system
from chain_impact.fmu.model_description import TOKEN, array_variables, model_description
from chain_impact.fmu.table import guid_of, model_table, packed
from chain_impact.variables.model import Model
from chain_impact.variables.table import word_index
from chain_impact.variables.variable import LARGEST

PLATFORMS = tuple(system.PLATFORMS)
"""All for which the kernel can be compiled."""
TABLE = "resources/model.bin"


def tool() -> str:
    """What has made the FMU. The package has no version yet where its wheel is built."""
    return f"chain-impact {version('chain-impact')}"


def native_files(model: Model, kernels: Mapping[str, Path], _scratch: Path) -> dict[str, bytes]:
    """All files of the FMU for FMI 2.0, by their names in it.

    Args:
        model: what it simulates.
        kernels: platform → library.
    """
    description = model_description(model, tool(), 2, canNotUseMemoryManagementFunctions="false")
    return _files(model, kernels, description, TOKEN[2], [])


def native_fmi3_files(model: Model, kernels: Mapping[str, Path], _scratch: Path) -> dict[str, bytes]:
    """Likewise for FMI 3.0."""
    place = word_index(model.start.dtype, ("step", "time"))
    time = ["time", "real", place, "independent", -LARGEST, LARGEST, "", place]
    arrays = [(model.table_row(array.variable), array.length) for array in array_variables(model)]
    kernels = {system.PLATFORMS[platform].fmi3: library for platform, library in kernels.items()}
    description = model_description(model, tool(), 3)
    return _files(model, kernels, description, TOKEN[3], [(time, 1), *arrays])


def _files(
    model: Model,
    kernels: Mapping[str, Path],
    description: ElementTree.Element,
    token: str,
    further: list[tuple[list[Any], int]],
) -> dict[str, bytes]:
    """The files of a description, whose attribute ``token`` is set, and of a table with further rows."""
    files = {
        f"binaries/{platform}/{model.scene.name}{library.suffix}": library.read_bytes()
        for platform, library in sorted(kernels.items())
    }
    table, record = {**model_table(model), "guid": ""}, model.start.tobytes()
    contents = (packed(table, record, further), ElementTree.tostring(description), *files.values())
    table["guid"] = guid_of(contents)
    description.set(token, table["guid"])
    files[TABLE] = packed(table, record, further)
    ElementTree.indent(description)
    files["modelDescription.xml"] = ElementTree.tostring(description, encoding="UTF-8", xml_declaration=True)
    return files
