"""The build backend: hatchling's, with the compilers for a wheel whose kernels are not cached.

An editable installation needs no compilers.
"""

import sys
from typing import Any

OLDEST = (3, 11)  # equal to requires-python of pyproject.toml, which pip reads after the build of the wheel
if sys.version_info < OLDEST:
    sys.exit(
        f"chain-impact needs Python 3.11 or later, and this is {sys.version.split()[0]} ({sys.base_prefix})"
    )

from hatchling import build  # noqa: E402
from hatchling.build import *  # noqa: E402, F403 - the other hooks, of which it has more or fewer under pip
from kernel_hook import kernels, say, target  # noqa: E402


def get_requires_for_build_wheel(  # type: ignore[no-redef]
    config_settings: dict[str, Any] | None = None,
) -> list[str]:
    """Return the requirements of a wheel's build besides [build-system] requires."""
    making = kernels()
    cached = making.all_cached(target(), release=making.prebuilt.is_release_build())
    compilers = [] if cached else making.REQUIREMENTS
    if compilers:
        say("the build needs compilers, some hundred megabytes, which are removed after it")
    return [*build.get_requires_for_build_wheel(config_settings), *compilers]
