"""An FMU that pythonfmu packages: a slave in Python, with the kernel behind it."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

from chain_impact.compilation.errors import BuildError
from chain_impact.fmu.model_description import model_description
from chain_impact.fmu.table import guid_of, model_table
from chain_impact.variables.model import Model

PLATFORMS = ("linux64", "win64")
"""Those for which pythonfmu has a wrapper."""
SCRIPT = """\
import ctypes

from {slave} import ChainImpact

# pythonfmu 0.7.0 gives these names back once for every instance without having taken them
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))
"""
"""The script that pythonfmu's wrapper executes anew for every instance; it then keeps its code and its names.

So it does no more than import the slave, which Python does once in a process.
"""
DESCRIPTION = "description.xml"  # what the slave's to_xml() gives the builder; not part of the FMU


def pythonfmu_files(model: Model, kernels: Mapping[str, Path], scratch: Path) -> dict[str, bytes]:
    """All files of the FMU, by their names in it.

    Args:
        model: what it simulates.
        kernels: platform → library.
        scratch: a folder to work in.

    Raises:
        BuildError: when pythonfmu fails.
    """
    built = _run_builder(_staged(model, kernels), model.scene.name, scratch)
    with zipfile.ZipFile(built) as fmu:
        return {name: fmu.read(name) for name in fmu.namelist() if _wanted(name, kernels)}


def _wanted(name: str, kernels: Mapping[str, Path]) -> bool:
    """Whether a file that pythonfmu has packed belongs to the FMU: no binary that was not asked for."""
    folder, _, rest = name.partition("/")
    return name != f"resources/{DESCRIPTION}" and (folder != "binaries" or rest.partition("/")[0] in kernels)


def slave_source() -> bytes:
    """The slave's source: beside this file when installed, else at the top of the repository's sources."""
    packaged = Path(__file__).with_name("slave.py")
    return (packaged if packaged.is_file() else Path(__file__).parents[2] / "slave.py").read_bytes()


def _staged(model: Model, kernels: Mapping[str, Path]) -> dict[str, bytes]:
    """The files that pythonfmu makes the FMU of, the slave's script first: name → content."""
    files = {"instance.bin": model.start.tobytes()}
    for platform, library in sorted(kernels.items()):
        files[f"kernel-{platform}{library.suffix}"] = library.read_bytes()
    checksum = zlib.crc32(files["instance.bin"])
    slave, table = slave_source(), {**model_table(model), "start_checksum": checksum}
    tool = f"chain-impact {version('chain-impact')} with PythonFMU {version('pythonfmu')}"
    description = model_description(model, tool, 2)

    guid = guid_of((slave, json.dumps(table).encode(), ElementTree.tostring(description), *files.values()))
    description.set("guid", guid)
    files["model.json"] = json.dumps({**table, "guid": guid}).encode()
    files[DESCRIPTION] = ElementTree.tostring(description)
    # the guid also names both modules: one process can hold several FMUs, and Python knows modules by name
    script = f"chain_impact_{guid.replace('-', '')[:16]}"
    files[f"{script}_slave.py"] = slave
    return {f"{script}.py": SCRIPT.format(slave=f"{script}_slave").encode(), **files}


def _run_builder(files: dict[str, bytes], name: str, scratch: Path) -> Path:
    """Let pythonfmu build an FMU from the files, the slave's script first; return its path."""
    staging, out = scratch / "staging", scratch / "out"
    staging.mkdir()
    for file, content in files.items():
        (staging / file).write_bytes(content)
    script, *others = files
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", script, "-d", str(out.resolve()), *others]
    options = ["--no-external-tool", "--handle-state", "--serialize-state"]
    # in a process of its own, as the builder imports the script and keeps it
    done = subprocess.run([*command, *options], cwd=staging, capture_output=True, text=True, check=False)
    fmu = out / f"{name}.fmu"
    if done.returncode != 0 or not fmu.is_file():
        raise BuildError(f"pythonfmu could not build the FMU:\n{done.stdout}{done.stderr}")
    return fmu
