"""A native FMU: its binary is the kernel's library, and a table describes the scene to this binary."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from chain_impact.fmu.model_bin import files_with_description
from chain_impact.fmu.model_description import array_variables, model_description
from chain_impact.fmu.versions import FMI_2
from chain_impact.scene.fast_values import LARGEST_NUMBER
from chain_impact.system import PLATFORMS
from chain_impact.variables.indices import word_index
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.variable import TableRow


def native_files(prepared_scene: PreparedScene, kernels: Mapping[str, Path], fmi: int) -> dict[str, bytes]:
    """Return the files with which a native FMU runs, as path in the FMU → content; build.py adds more files.

    Args:
        prepared_scene: the scene that the FMU simulates.
        kernels: platform → library of the kernel.
        fmi: the version of FMI, 2 or 3.
    """
    # the version is read here, not at import, because the package has no version while its wheel is built
    tool_name, further_rows = f"chain-impact {version('chain-impact')}", list[tuple[TableRow, int]]()
    if fmi == FMI_2:
        description = model_description(
            prepared_scene, tool_name, fmi, canNotUseMemoryManagementFunctions="false"
        )
    else:
        description = model_description(prepared_scene, tool_name, fmi)
        kernels = {PLATFORMS[platform].fmi3: library for platform, library in kernels.items()}
        time_index = word_index(prepared_scene.start.dtype, ("step", "communication_point"))
        time = TableRow(
            name="time",
            type="real",
            word=time_index,
            role="independent",
            low=-LARGEST_NUMBER,
            high=LARGEST_NUMBER,
            allowed="",
            set_word=time_index,
        )
        further_rows = [(time, 1)]
        further_rows += [
            (prepared_scene.table_row(array.variable), array.length)
            for array in array_variables(prepared_scene)
        ]
    files = {
        f"binaries/{platform}/{prepared_scene.scene.name}{library.suffix}": library.read_bytes()
        for platform, library in sorted(kernels.items())
    }
    return files_with_description(files, prepared_scene, description, fmi, further_rows)
