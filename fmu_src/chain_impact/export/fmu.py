"""Package a scene as an FMU: stage the files, let pythonfmu build, make the zip reproducible, validate."""

from __future__ import annotations

import hashlib
import json
import math
import os
import subprocess
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from chain_impact.compilation.compilers import ZIG_TARGETS
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.library import kernel_library
from chain_impact.compilation.work import Notify, announce
from chain_impact.export.description import model_description
from chain_impact.instance import new_instance
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene import Scene, load_scene
from chain_impact.variables import Variable, fmu_variables, word_index

LARGEST = sys.float_info.max
ZIP_DATE = (1980, 1, 1, 0, 0, 0)
DESCRIPTION = "description.xml"  # what the slave's to_xml() gives the builder; not part of the FMU


def build_fmu(
    source: Scene | str | os.PathLike[str],
    directory: str | os.PathLike[str] = ".",
    *,
    platforms: Sequence[str] = ("linux64",),
    notify: Notify = announce,
) -> Path:
    """Build ``<name>.fmu``, which appears in the directory only when it is complete and valid.

    Equal scenes, with the same versions of this package, make FMUs of equal bytes.

    Args:
        source: a scene, or what ``load_scene`` takes.
        directory: where to put the FMU; it is created if need be.
        platforms: of ``linux64`` and ``win64``, those that the FMU shall run on.
        notify: called with a sentence before work that takes seconds.

    Returns:
        The path of the FMU.

    Raises:
        SceneError: when the source is no valid scene.
        BuildError: when the kernel cannot be compiled or the FMU is not valid.
    """
    scene = source if isinstance(source, Scene) else load_scene(source)
    if not platforms or set(platforms) - set(ZIG_TARGETS):
        raise BuildError(f"platforms = {list(platforms)} must be some of {', '.join(ZIG_TARGETS)}")
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    # inside the directory, so that the finished FMU can be moved to its place at once
    with tempfile.TemporaryDirectory(prefix=f".{scene.name}-", dir=directory) as scratch:
        files = _staged_files(scene, platforms, notify)
        notify("packaging the FMU")
        raw = _run_builder(files, scene.name, Path(scratch))
        fmu = Path(scratch, f"{scene.name}.fmu")
        _repack(raw, fmu, platforms)
        notify("validating the FMU")
        problems = validate_fmu(fmu)
        if problems:
            raise BuildError(f"{fmu.name} is not valid: " + "; ".join(problems))
        return fmu.replace(directory / fmu.name)


def validate_fmu(path: str | os.PathLike[str]) -> list[str]:
    """Check an FMU against the FMI standard; return what is wrong with it, a sentence each."""
    from fmpy.validation import validate_fmu as problems_of  # takes a second, so not at the top

    try:
        return [str(problem) for problem in problems_of(str(path))]
    except zipfile.BadZipFile as error:
        return [f"not an FMU: {error}"]


def slave_source() -> bytes:
    """The slave's source: beside this file when installed, else at the top of the repository's sources."""
    packaged = Path(__file__).with_name("slave.py")
    return (packaged if packaged.is_file() else Path(__file__).parents[2] / "slave.py").read_bytes()


def _staged_files(scene: Scene, platforms: Sequence[str], notify: Notify) -> dict[str, bytes]:
    """The files that make the FMU, the slave's script first: name → content."""
    instance = new_instance(scene)
    links = len(scene.chain.links)
    files = {"instance.bin": instance.tobytes()}
    for platform in sorted(platforms):
        library = kernel_library(links, platform, notify, law_file=scene.contact.law_file)
        files[f"kernel-{platform}{library.suffix}"] = library.read_bytes()
    slave, model, description = slave_source(), _model_table(scene), model_description(scene, guid="")

    # one fingerprint for all: the FMU's guid, and the name of the script. One process can hold several FMUs,
    # and Python knows a module by its name only
    digest = hashlib.sha256()
    for content in (slave, json.dumps(model).encode(), ElementTree.tostring(description), *files.values()):
        digest.update(len(content).to_bytes(8, "big") + content)
    model["guid"] = str(uuid.UUID(bytes=digest.digest()[:16]))
    description.set("guid", model["guid"])
    files["model.json"] = json.dumps(model).encode()
    files[DESCRIPTION] = ElementTree.tostring(description)
    return {f"chain_impact_{digest.hexdigest()[:16]}.py": slave, **files}


def _model_table(scene: Scene) -> dict[str, Any]:
    """What the slave knows of the model."""
    variables, layout = fmu_variables(scene), new_instance(scene).dtype
    places = {
        "time": ("step", "time"),
        "changed": ("inputs", "changed"),
        "tolerance": ("solver", "tolerance"),
    }
    return {
        "name": scene.name,
        "variables": [_variable_row(variable, word_index(layout, variable.place)) for variable in variables],
        "first_output": sum(variable.causality != "output" for variable in variables),
        "words": {name: word_index(layout, place) for name, place in places.items()},
        "statuses": {str(status): text for status, text in STATUS_TEXT.items()},
    }


def _variable_row(variable: Variable, word: int) -> list[Any]:
    """Name, type, word, kind, lowest and highest value that can be set, and these in words."""
    kind = variable.variability if variable.causality == "parameter" else variable.causality
    low, high = -LARGEST, LARGEST
    if variable.items:
        low, high = 1, len(variable.items)
    elif variable.above is not None:
        low = math.nextafter(variable.above, math.inf)
    elif variable.minimum is not None:
        low = variable.minimum
    if variable.maximum is not None:
        high = variable.maximum
    type_ = "real" if variable.type == "real" else "integer"
    return [variable.name, type_, word, kind, low, high, variable.allowed]


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


def _repack(source: Path, target: Path, platforms: Sequence[str]) -> None:
    """Copy a zip: compressed, in the order of names, without dates and without binaries not asked for."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in sorted(old.namelist()):
            folder, _, rest = name.partition("/")
            unwanted = folder == "binaries" and rest.partition("/")[0] not in platforms
            if unwanted or name == f"resources/{DESCRIPTION}":
                continue
            entry = zipfile.ZipInfo(name, ZIP_DATE)
            entry.create_system, entry.external_attr = 3, 0o100644 << 16  # a plain file, as on Unix
            new.writestr(entry, old.read(name), zipfile.ZIP_DEFLATED, compresslevel=9)
