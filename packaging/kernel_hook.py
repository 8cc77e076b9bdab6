"""Put the prebuilt kernels into a wheel, and tag the wheel with their platform."""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PACKAGE = Path(__file__).parents[1] / "fmu_src" / "chain_impact"
PLATFORM = "CHAIN_IMPACT_PLATFORM"
"""The environment variable with the platform of the wheel; the default is this machine's platform."""


def kernels() -> ModuleType:
    """Return the module prebuilt_kernels, without the rest of the package and its requirements.

    If the folder of the cache cannot be used, CHAIN_IMPACT_CACHE is set to a new temporary folder.
    """
    if "chain_impact" not in sys.modules:
        package = ModuleType("chain_impact")
        package.__path__ = [str(PACKAGE)]
        sys.modules["chain_impact"] = package
    try:
        folders = import_module("chain_impact.compilation.folders")
        folders.make_folder(folders.base_folder())
    except RuntimeError:  # the build has no home folder, or no space there
        os.environ["CHAIN_IMPACT_CACHE"] = tempfile.mkdtemp(prefix="chain-impact-")
    here = str(Path(__file__).parent)
    if here not in sys.path:  # a build without backend.py lacks this folder
        sys.path.insert(0, here)
    return import_module("prebuilt_kernels")


def platforms() -> dict[str, Any]:
    """Return all platforms, by name, as in chain_impact.system."""
    kernels()
    found: dict[str, Any] = import_module("chain_impact.system").PLATFORMS
    return found


def tag(platform: str) -> str:
    """Return the tag of a wheel; any Python fits, because the shared libraries do not use Python."""
    return f"py3-none-{platforms()[platform].tag}"


def target() -> str:
    """Return the platform of the wheel: this machine's, or the value of CHAIN_IMPACT_PLATFORM.

    Raises:
        RuntimeError: when no kernels exist for this machine or for that platform.
    """
    kernels()
    system = import_module("chain_impact.system")
    given = os.environ.get(PLATFORM)
    if given and given not in system.PLATFORMS:
        raise RuntimeError(f"{PLATFORM} = {given} must be one of {', '.join(system.PLATFORMS)}")
    if not (given or system.HOST):
        raise RuntimeError(system.no_kernel_sentence())
    return given or str(system.HOST)


def say(sentence: str) -> None:
    """Write a line at once to the terminal, or to standard error where there is none.

    pip shows a build's standard error with -v only. A background job writes to standard error, because the
    terminal could stop it.
    """
    line = f"chain-impact: {sentence}\n"
    with suppress(OSError, AttributeError), Path("/dev/tty").open("w", encoding="utf-8") as terminal:
        if os.tcgetpgrp(terminal.fileno()) == os.getpgrp():
            terminal.write(f"\r\033[K{line}")  # overwrites the line that the installer has begun
            return
    sys.stderr.write(line)
    sys.stderr.flush()


class KernelHook(BuildHookInterface[Any]):
    """A build hook that hatchling calls for each wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the kernels to the wheel; an editable wheel gets none, because its sources will change."""
        if version == "editable":
            return
        making, platform = kernels(), target()
        prebuilt, release = making.prebuilt, making.prebuilt.is_release_build()
        self.scratch = tempfile.TemporaryDirectory(prefix="chain-impact-")
        folder = Path(self.scratch.name, prebuilt.FOLDER.name)
        cached = making.all_cached(platform, release=release)
        making.make(folder, platform, release=release, say=say)
        if not cached:
            say("the kernels are ready")
        build_data["force_include"][str(folder)] = f"chain_impact/{prebuilt.FOLDER.name}"
        build_data["pure_python"] = False
        build_data["tag"] = tag(platform)

    def finalize(self, version: str, _build_data: dict[str, Any], _artifact: str) -> None:
        """Delete the temporary files."""
        if version != "editable":
            self.scratch.cleanup()
