"""Put the ready kernels into a wheel, and mark it with the platform that they are for."""

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
TAGS = {
    "linux64": "manylinux_2_17_x86_64",  # for glibc 2.17 or later
    "win64": "win_amd64",
    "darwin64": "macosx_11_0_x86_64",
    "aarch64-linux": "manylinux_2_17_aarch64",
    "aarch64-darwin": "macosx_11_0_arm64",
}
"""The tag of a wheel's platform; any Python will do, as it does not know the shared libraries."""
PLATFORM = "CHAIN_IMPACT_PLATFORM"
"""The variable that names the platform of the wheel; by default it is this machine's."""


def kernels() -> ModuleType:
    """The module ready_kernels, without the rest of the package and what that needs installed."""
    if "chain_impact" not in sys.modules:
        package = ModuleType("chain_impact")
        package.__path__ = [str(PACKAGE)]
        sys.modules["chain_impact"] = package
    try:
        places = import_module("chain_impact.compilation.places")
        places.writable(places.base_folder())
    except RuntimeError:  # who builds has no home, or no space there
        os.environ["CHAIN_IMPACT_CACHE"] = tempfile.mkdtemp(prefix="chain-impact-")
    here = str(Path(__file__).parent)
    if here not in sys.path:  # of a build that does not go through backend.py
        sys.path.insert(0, here)
    return import_module("ready_kernels")


def target() -> str:
    """The platform that the wheel is for: that of this machine, or the one that CHAIN_IMPACT_PLATFORM names.

    Raises:
        RuntimeError: when this machine is none of them, or there is no such platform.
    """
    kernels()
    system = import_module("chain_impact.system")
    given = os.environ.get(PLATFORM)
    if given and given not in TAGS:
        raise RuntimeError(f"{PLATFORM} = {given} must be one of {', '.join(TAGS)}")
    if not (given or system.HOST):
        raise RuntimeError(system.nowhere())
    return given or str(system.HOST)


def say(sentence: str) -> None:
    """Write a line at once to the terminal, or to standard error where there is none.

    What a build writes to standard error, pip shows with -v only. A job in the background leaves the terminal
    alone, which may stop who writes there.
    """
    line = f"chain-impact: {sentence}\n"
    with suppress(OSError, AttributeError), Path("/dev/tty").open("w", encoding="utf-8") as terminal:
        if os.tcgetpgrp(terminal.fileno()) == os.getpgrp():
            terminal.write(f"\r\033[K{line}")  # in the place of what an installer has begun there
            return
    sys.stderr.write(line)
    sys.stderr.flush()


class KernelHook(BuildHookInterface):
    """Called by hatchling for each wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the kernels to the wheel; an editable one gets none, as its sources will change."""
        if version == "editable":
            return
        making, platform = kernels(), target()
        ready, release = making.ready, making.ready.for_release()
        self.scratch = tempfile.TemporaryDirectory(prefix="chain-impact-")
        folder = Path(self.scratch.name, ready.FOLDER.name)
        cached = making.all_cached(platform, release=release)
        making.make(folder, platform, release=release, say=say)
        if not cached:
            say("the kernels are ready")
        build_data["force_include"][str(folder)] = f"chain_impact/{ready.FOLDER.name}"
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{TAGS[platform]}"

    def finalize(self, version: str, _build_data: dict[str, Any], _artifact: str) -> None:
        """Clean up."""
        if version != "editable":
            self.scratch.cleanup()
