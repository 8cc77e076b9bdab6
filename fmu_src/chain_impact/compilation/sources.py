"""The sources and compilers from which kernels are made, and a fingerprint of both."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from chain_impact.system import PLATFORMS

PACKAGE = Path(__file__).parents[1]
# The modules of this folder that make code, so that a change of them may change kernels. The other modules
# find, store and describe kernels.
MAKERS = (
    *("affine", "browser", "built_in", "collecting", "compilers", "dual_numbers", "entry_points"),
    *("functions", "law", "lower", "numba_parts", "record_type", "signatures"),
)
# The folders and files of the package from which kernels are made.
COMPILED = (
    "kernel",
    *(f"compilation/{name}.py" for name in MAKERS),
    "compilation/c_interface",
    "user_laws",
)
# Name of a package → the version that compilation needs, as in the extra "compiler" of pyproject.toml.
COMPILERS = {"llvmlite": "0.50.0", "numba": "0.68.1", "ziglang": "0.17.0"}
LANGUAGES = (".py", ".c", ".h")  # the suffixes of files in the folders of COMPILED that are sources


@cache
def fingerprint() -> str:
    """Return 16 hexadecimal digits that identify the sources, COMPILERS, and PLATFORMS' targets and CPUs."""
    platforms = {name: (platform.target, platform.cpu) for name, platform in PLATFORMS.items()}
    digest = hashlib.sha256(repr((COMPILERS, platforms)).encode())
    for source in sorted(_sources()):
        name, content = source.relative_to(PACKAGE).as_posix().encode(), source.read_bytes()
        digest.update(len(name).to_bytes(8, "big") + name + len(content).to_bytes(8, "big") + content)
    return digest.hexdigest()[:16]


def _sources() -> Iterator[Path]:
    for name in COMPILED:
        path = PACKAGE / name
        yield from (file for file in path.rglob("*") if file.suffix in LANGUAGES) if path.is_dir() else [path]
