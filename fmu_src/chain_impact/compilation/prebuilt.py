"""The prebuilt kernels in a wheel, with which most users need no compiler.

packaging/prebuilt_kernels.py, at the top of the repository, makes the prebuilt kernels when a wheel is built.
A wheel for release also has kernels that are each for one number of links. An editable installation has no
prebuilt kernels: a kernel is compiled at its first use, and stored in the cache.
"""

from __future__ import annotations

import functools
import lzma
import os
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from chain_impact.compilation import browser, cache, compilers
from chain_impact.compilation.compilers import DERIVATIVES, KERNEL, AnyLinks, KernelScope
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.sources import COMPILERS, PACKAGE, fingerprint
from chain_impact.extras import how_to_install
from chain_impact.system import PLATFORMS

FOLDER = PACKAGE / "prebuilt"
MODULE = f"{KERNEL}.ll.xz"  # the file in each wheel with the lowered kernel, compressed
# the file with the fingerprint of the sources from which the prebuilt kernels were made; they are used only
# if the present sources have the same fingerprint
MADE_FROM = "sources.txt"
# The environment variable that is "1" while a wheel for release is built.
RELEASE = "CHAIN_IMPACT_RELEASE"
# The largest number of links for which a wheel for release has a kernel of its own. Chains with more links
# share a kernel that reads the number of links from the record. With the shared kernel, runs of up to ten
# links would take 10 % to 30 % longer, with many rows of outputs up to 40 %; runs of thirty links take no
# longer.
LARGEST_EXACT = 10

# The scenes of the kernels without derivatives in a wheel for release. In other wheels, and for kernels with
# derivatives, there are only those of ``AnyLinks``.
WHEEL_SCOPES: tuple[int | AnyLinks, ...] = (*AnyLinks, *range(1, LARGEST_EXACT + 1))
# Kind of library → parts of the kernel that are compiled and linked for it.
LIBRARY_PARTS = {KERNEL: (KERNEL,), DERIVATIVES: (KERNEL, DERIVATIVES)}


def missing_compilers() -> list[str]:
    """Return the names of the packages of COMPILERS that are not installed."""
    return [name for name in COMPILERS if find_spec(name) is None]


def require_compilers(purpose: str) -> None:
    """Refuse a task that needs all COMPILERS if one of them is not installed.

    Raises:
        BuildError: when a compiler is not installed; ``purpose``, such as "this kernel", begins the message.
    """
    if missing_packages := missing_compilers():
        advice = how_to_install("compiler")
        raise BuildError(f"{purpose} needs a compiler: {advice} ({', '.join(missing_packages)} missing)")


def is_release_build() -> bool:
    """Return whether a wheel for release is being built, which has the kernels of ``wheel_scopes``."""
    return os.environ.get(RELEASE) == "1"


def exact_scope(scope: KernelScope, library_kind: str = KERNEL) -> KernelScope:
    """Return the scenes for which to compile the kernel that runs the scenes ``scope``.

    If ``scope`` is a number of links, the result is this number while a wheel for release is built that gets
    a kernel for this number, else ``AnyLinks.PLAIN``. For any other ``scope``, the result is ``scope``.
    ``library_kind`` is KERNEL or DERIVATIVES.
    """
    if isinstance(scope, tuple) or scope in wheel_scopes(library_kind, is_release_build()):
        return scope
    return AnyLinks.PLAIN


def wheel_scopes(library_kind: str, release: bool) -> tuple[int | AnyLinks, ...]:
    """Return the entries of WHEEL_SCOPES for which a wheel has kernels of a ``library_kind``.

    ``library_kind`` is KERNEL or DERIVATIVES; ``release`` says whether the wheel is for release.
    """
    # with derivatives, a kernel for one number of links would be only 5 % faster, so no wheel has one
    return WHEEL_SCOPES if release and library_kind == KERNEL else tuple(AnyLinks)


def library_name(scope: KernelScope, platform: str, law: str = "", library_kind: str = KERNEL) -> str:
    """Return the file name of a kernel of a ``library_kind`` for a platform; ``scope``: its scenes.

    ``law`` is the name of the user's law in the kernel, with a checksum of its text; "" without a law.
    """
    suffix = PLATFORMS[platform].suffix
    if isinstance(scope, tuple):
        size_text = "_".join(map(str, scope))
    else:
        size_text = scope.value if isinstance(scope, AnyLinks) else str(scope)
    return "-".join(filter(None, (library_kind, size_text, law, platform))) + suffix


def find(name: str) -> Path | None:
    """Return the path of the prebuilt file ``name``; None if there is none from the present sources."""
    return FOLDER / name if _is_usable() and (FOLDER / name).is_file() else None


def best_kernel(scope: KernelScope, platform: str, library_kind: str) -> Path | None:
    """Return the path of a prebuilt kernel of a ``library_kind`` that can run the scenes ``scope``, or None.

    For a number of links, this is the kernel for any number if there is no prebuilt kernel for this number.
    """
    scopes = (scope, AnyLinks.PLAIN) if isinstance(scope, int) else (scope,)
    names = (library_name(kernel_scope, platform, library_kind=library_kind) for kernel_scope in scopes)
    return next(filter(None, map(find, names)), None)


def lowered_kernel() -> str | None:
    """Return the text of the lowered kernel in the wheel; None if there is none from the present sources."""
    packed = find(MODULE)
    return lzma.decompress(packed.read_bytes()).decode() if packed else None


def prebuilt_kernels() -> list[Path]:
    """Return the sorted paths of all prebuilt kernels; none if they were made from other sources."""
    return sorted(FOLDER.glob("*-*")) if _is_usable() else []


@functools.cache
def _is_usable() -> bool:
    mark = FOLDER / MADE_FROM
    return mark.is_file() and mark.read_text() == fingerprint()


def object_file(scope: KernelScope, platform: str, part: str, text: Callable[[], str]) -> Path:
    """Return the object file of ``part`` of a kernel from the cache, or compile the part.

    The part is for the scenes ``scope``. ``text`` returns the lowered part; it is called only if the part is
    not in the cache.
    """
    name = Path(library_name(scope, platform, library_kind=part)).with_suffix(".o").name
    make = functools.partial(compilers.compile_part, platform=platform, part=part, scope=scope)
    return cache.get_or_make(name, lambda file: make(text(), file))


def browser_object_file(text: Callable[[], str]) -> Path:
    """Return the object file of the kernel for browsers from the cache, or compile the kernel.

    ``text`` returns the lowered kernel; it is called only if the object file is not in the cache.
    """
    return cache.get_or_make(browser.COMPILED, lambda file: browser.compile_kernel(text(), file))
