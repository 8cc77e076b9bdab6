"""A native FMU: the kernel's library is its binary, a table tells the C interface in it of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

from chain_impact.compilation.compilers import ZIG_TARGETS
from chain_impact.export.description import model_description
from chain_impact.export.table import guid_of, model_table, packed
from chain_impact.instance import new_instance
from chain_impact.scene import Scene

PLATFORMS = tuple(ZIG_TARGETS)
"""All for which the kernel can be compiled."""
TABLE = "resources/model.bin"


def native_files(scene: Scene, kernels: Mapping[str, Path], _scratch: Path) -> dict[str, bytes]:
    """All files of the FMU, by their names in it.

    Args:
        scene: what it simulates.
        kernels: platform → library.
    """
    files = {
        f"binaries/{platform}/{scene.name}{library.suffix}": library.read_bytes()
        for platform, library in sorted(kernels.items())
    }
    model, record = {**model_table(scene), "guid": ""}, new_instance(scene).tobytes()
    description = model_description(
        scene, f"chain-impact {version('chain-impact')}", canNotUseMemoryManagementFunctions="false"
    )
    model["guid"] = guid_of((packed(model, record), ElementTree.tostring(description), *files.values()))
    description.set("guid", model["guid"])
    files[TABLE] = packed(model, record)
    ElementTree.indent(description)
    files["modelDescription.xml"] = ElementTree.tostring(description, encoding="UTF-8", xml_declaration=True)
    return files
