"""The platforms for which an FMU has binaries, and the binary for this machine."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Collection
from pathlib import Path

from chain_impact.fmu.findings import Finding
from chain_impact.system import HOST, PLATFORMS


def platforms_of(path: str | Path) -> list[str]:
    """Return the platforms for which an FMU has binaries.

    A platform that this package knows has its name as in ``--platform``, any other the name of its folder in
    the FMU.
    """
    platform_names = {platform.fmi3: name for name, platform in PLATFORMS.items()}
    with zipfile.ZipFile(path) as fmu:
        return [platform_names.get(folder, folder) for folder in _folders(fmu.namelist())]


def binary_of(identifier: str, names: Collection[str], *, is_fmi_2: bool) -> tuple[str, Finding | None]:
    """Return (path, None) with the path in the FMU of the binary that an importer loads on this machine.

    If the FMU has no such file, return ("", finding).

    Args:
        identifier: the attribute ``modelIdentifier``, the name of the binary without its suffix.
        names: the paths of files and folders in the FMU.
        is_fmi_2: whether the FMU is of FMI 2.0: then the folder with the name of FMI 2.0 is looked at first,
            else that with the name of FMI 3.0.
    """
    platforms = [HOST, PLATFORMS[HOST].fmi3] if HOST else []
    platforms = platforms if is_fmi_2 else platforms[::-1]
    file = f"{identifier}{PLATFORMS[HOST].suffix if HOST else ''}"
    paths = [f"binaries/{platform}/{file}" for platform in platforms]
    for path in paths:
        if path in names:
            return path, None
    if other_folders := _folders(names):
        folder_text = f"it has folders for {', '.join(other_folders)}"
    elif any(name.startswith("binaries/") for name in names):
        folder_text = "its folder binaries is empty"
    else:
        folder_text = "it has no folder binaries"
    fault = f"is not in the FMU, so there is no binary for {HOST or 'this platform'}: {folder_text}"
    return "", Finding(fault, paths[0] if paths else "binaries")


def _folders(names: Collection[str]) -> list[str]:
    """Return the sorted names of the folders in ``binaries`` that directly contain a file."""
    folder_matches = (re.fullmatch(r"binaries/([^/]+)/[^/]+", name) for name in names)
    return sorted({file[1] for file in folder_matches if file})
