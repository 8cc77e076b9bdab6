"""The build of an FMU from a scene: its files are packed into a zip, which is then validated.

Equal scenes and arguments give zips with equal bytes, with the same versions of all packages.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.library import kernel_library
from chain_impact.files import written_atomically
from chain_impact.fmu.documents import documents
from chain_impact.fmu.native_target import native_files
from chain_impact.fmu.pythonfmu_target import pythonfmu_files
from chain_impact.fmu.references import reference_files
from chain_impact.fmu.scene_data import scene_data_file
from chain_impact.fmu.validate import validate_fmu
from chain_impact.fmu.versions import FMI_2, FMI_3, VERSIONS
from chain_impact.progress import log
from chain_impact.scene.scene import SceneSource, scene_of
from chain_impact.system import HOST, PLATFORMS, no_kernel_sentence
from chain_impact.variables.prepared import PreparedScene, kernel_scope

ZIP_DATE = (1980, 1, 1, 0, 0, 0)

TARGETS = {
    "pythonfmu": tuple(name for name, platform in PLATFORMS.items() if platform.has_pythonfmu),
    "native": tuple(PLATFORMS),
}
"""Kind of FMU → the platforms for which FMUs of this kind can be built."""
TARGET = "pythonfmu" if HOST in TARGETS["pythonfmu"] else "native"
"""The kind of FMU for FMI 2.0 that is built on this machine if no kind is given."""


def build_fmu(
    source: SceneSource,
    directory: str | os.PathLike[str] = ".",
    *,
    target: str = TARGET,
    fmi: int = FMI_2,
    platforms: Sequence[str] = (HOST,),
) -> Path:
    """Build ``<name>.fmu``; the file appears in the directory only when it is complete and valid.

    Equal scenes give FMUs with equal bytes, with the same versions of this package and of those that it uses.

    Args:
        source: a scene, or an argument of ``load_scene``.
        directory: the folder for the FMU, which is created if necessary.
        target: ``pythonfmu``, which runs in the Python of the importer, or ``native``, which needs no Python.
            Both have the same variables and give the same results. ``pythonfmu`` exists for Linux and Windows
            on x86-64 only; on these it is the default, on any other machine ``native`` is.
        fmi: 2 or 3, the version of FMI; for 3, ``target`` must be ``native``.
        platforms: the platforms of the FMU, by default this machine's: ``linux64``, ``win64``, and for native
            FMUs ``darwin64``, ``aarch64-linux`` and ``aarch64-darwin``; or ``all`` alone.

    Returns:
        The path of the FMU.

    Raises:
        SceneError: when the source is not a valid scene.
        BuildError: when there is no such target, version or platform, the kernel cannot be compiled, or the
            FMU is not valid.
        OSError: when the FMU cannot be written; no part of the FMU is left then.
    """
    scene = scene_of(source)
    platforms = _checked_platforms(target, fmi, platforms)
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    scope, law, has_sensitivities = (
        kernel_scope(scene),
        scene.contact.law_file,
        bool(scene.outputs.sensitivities),
    )
    kernels = {
        platform: kernel_library(scope, platform, law_file=law, derivatives=has_sensitivities)
        for platform in platforms
    }
    fmu, prepared_scene = directory / f"{scene.name}.fmu", PreparedScene(scene)
    with written_atomically(fmu) as path:
        log.debug("packaging the FMU")
        is_native = target == "native"
        files = (
            native_files(prepared_scene, kernels, fmi)
            if is_native
            else pythonfmu_files(prepared_scene, kernels)
        )
        files |= (
            scene_data_file(prepared_scene) | documents(prepared_scene, fmi) | reference_files(prepared_scene)
        )
        _pack(files, path)
        log.debug("validating the FMU")
        problems = validate_fmu(path)
        if problems:
            raise BuildError(f"{path.name} is not valid: " + "; ".join(problems))
    return fmu


def _checked_platforms(target: str, fmi: int, platforms: Sequence[str]) -> Sequence[str]:
    """Return the platforms of an FMU, where ``["all"]`` stands for all that the target supports.

    Raises:
        BuildError: when there is no such target, version or platform, or the three do not fit each other.
    """
    if fmi not in VERSIONS:
        raise BuildError(f"fmi = {fmi!r} must be one of {', '.join(map(str, VERSIONS))}")
    if target not in TARGETS:
        raise BuildError(f"target = {target!r} must be one of {', '.join(TARGETS)}")
    if fmi == FMI_3 and target != "native":
        raise BuildError(f"target = {target!r} makes FMUs for FMI 2.0 only: FMI 3.0 needs target = 'native'")
    supported = TARGETS[target]
    if not all(platforms):
        raise BuildError(no_kernel_sentence())
    platforms = supported if list(platforms) == ["all"] else platforms
    if not platforms or set(platforms) - set(supported):
        target_hint = (
            "" if target == "native" or set(platforms) - set(PLATFORMS) else "; target = 'native' has all"
        )
        raise BuildError(f"platforms = {list(platforms)} must be some of {', '.join(supported)}{target_hint}")
    return platforms


def _pack(files: Mapping[str, bytes], target: Path) -> None:
    """Write a compressed zip whose bytes depend only on ``files`` (name → content).

    For this purpose the entries of the zip are sorted by name, and have the same date, ZIP_DATE.
    """
    with zipfile.ZipFile(target, "w") as fmu:
        for name, content in sorted(files.items()):
            entry = zipfile.ZipInfo(name, ZIP_DATE)
            # the entry is a file of Unix that its owner may write and everyone may read, whatever the system
            # of this machine
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            fmu.writestr(entry, content, zipfile.ZIP_DEFLATED, compresslevel=9)
