"""An FMU that runs in the importer's Python: pythonfmu's wrapper as binary, slave.py, and the kernel."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import distribution, version
from pathlib import Path

from chain_impact.files import packaged_path
from chain_impact.fmu.model_bin import files_with_description
from chain_impact.fmu.model_description import model_description
from chain_impact.fmu.versions import FMI_2
from chain_impact.system import PLATFORMS
from chain_impact.variables.prepared import PreparedScene

SCRIPT = """\
import ctypes

from {slave} import ChainImpact

# pythonfmu 0.7.0 releases a reference to these names for every instance, without having taken one
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))
"""
"""The script of an FMU, which pythonfmu's wrapper executes again for every new instance.

The wrapper never frees the code of an executed script. So this script is short: it imports the slave, which
Python loads only once in a process, and takes the reference to the script's names that the wrapper releases.
"""


def pythonfmu_files(prepared_scene: PreparedScene, kernels: Mapping[str, Path]) -> dict[str, bytes]:
    """Return the files with which the FMU runs, as path in the FMU → content; build.py adds others.

    Args:
        prepared_scene: the scene that the FMU simulates.
        kernels: platform → library of the kernel.
    """
    tool_name = f"chain-impact {version('chain-impact')} with PythonFMU {version('pythonfmu')}"
    sources = {"script": SCRIPT.encode(), "slave": slave_source()}
    files = sources | _pythonfmu_files(prepared_scene.scene.name, kernels)
    for platform, library in sorted(kernels.items()):
        files[f"resources/kernel-{platform}{library.suffix}"] = library.read_bytes()
    description = model_description(prepared_scene, tool_name, FMI_2)
    files = files_with_description(files, prepared_scene, description, FMI_2)
    # The names of script and slave contain a part of the GUID, because a process may load several FMUs, and
    # Python imports only one module of a name.
    guid = description.attrib["guid"]
    script = f"chain_impact_{guid.replace('-', '')[:16]}"
    modules = {
        f"resources/{script}.py": SCRIPT.format(slave=f"{script}_slave").encode(),
        f"resources/{script}_slave.py": sources["slave"],
        # the wrapper reads the name of the script from this file, and the slave the name of the model and the
        # GUID, as some importers do not unpack modelDescription.xml
        "resources/slavemodule.txt": "\n".join((script, prepared_scene.scene.name, guid)).encode(),
    }
    return {name: content for name, content in files.items() if name not in sources} | modules


def slave_source() -> bytes:
    """Return the text of slave.py, from the installed chain_impact or from the repository."""
    return packaged_path("fmu/slave.py", "fmu_src/slave.py").read_bytes()


def _pythonfmu_files(name: str, platforms: Mapping[str, Path]) -> dict[str, bytes]:
    """Return pythonfmu's Python modules, and its wrappers as binaries with the name ``name``."""
    # from the installed package, because a module `pythonfmu` that this process has loaded may come from an
    # FMU
    folder = Path(str(distribution("pythonfmu").locate_file("pythonfmu")))
    files = {f"resources/pythonfmu/{module.name}": module for module in folder.glob("*.py")}
    for platform in platforms:
        suffix = PLATFORMS[platform].suffix
        wrapper = next(folder.glob(f"resources/binaries/{platform}/*{suffix}"))
        files[f"binaries/{platform}/{name}{suffix}"] = wrapper
    return {name: path.read_bytes() for name, path in sorted(files.items())}
