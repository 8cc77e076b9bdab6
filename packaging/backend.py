"""The build backend: hatchling's, with the compilers for a wheel whose kernels are not cached.

An editable installation needs no compilers.
"""

from typing import Any

from hatchling import build
from hatchling.build import *  # noqa: F403 - the other hooks, of which it has more or fewer under pip
from kernel_hook import kernels


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """What to install for a wheel besides [build-system] requires."""
    ready = kernels()
    compilers = [] if ready.all_cached() else ready.REQUIREMENTS
    return [*build.get_requires_for_build_wheel(config_settings), *compilers]
