"""Make the kernels that a wheel carries, and mark the wheel with the platform that they are for."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCES = "fmu_src"
TAG = "py3-none-manylinux_2_17_x86_64"  # shared libraries that Python does not know, for glibc 2.17 or later
PLATFORM = ("Linux", "x86_64")


class KernelHook(BuildHookInterface):
    """Called by hatchling for each wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the ready kernels to the wheel; an editable one gets none, as its sources will change."""
        if version == "editable":
            return
        if (platform.system(), platform.machine()) != PLATFORM:
            raise RuntimeError(f"chain-impact runs on {' '.join(PLATFORM)}, not on {platform.platform()}")
        sys.path.insert(0, str(Path(self.root, SOURCES)))
        from chain_impact.compilation import ready

        self.scratch = tempfile.TemporaryDirectory(prefix="chain-impact-")
        os.environ["CHAIN_IMPACT_CACHE"] = str(Path(self.scratch.name, "cache"))
        kernels = Path(self.scratch.name, ready.FOLDER.name)
        ready.make(kernels)
        build_data["force_include"][str(kernels)] = f"chain_impact/{ready.FOLDER.name}"
        build_data["pure_python"] = False
        build_data["tag"] = TAG

    def finalize(self, version: str, _build_data: dict[str, Any], _artifact: str) -> None:
        """Clean up."""
        if version != "editable":
            self.scratch.cleanup()
