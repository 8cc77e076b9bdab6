"""Gets a kernel as a shared library or a module for browsers: prebuilt, from the cache, or newly compiled."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from chain_impact.compilation import browser, cache, compilers, prebuilt
from chain_impact.compilation.compilers import DERIVATIVES, KERNEL, KernelScope
from chain_impact.compilation.errors import BuildError
from chain_impact.progress import log_once
from chain_impact.system import HOST, no_kernel_sentence
from chain_impact.user_laws.law_file import LawError, UserLaw, read_law

# [s] usual times for each part of a kernel, which messages tell: LOWERING to lower it, LINKING to compile and
# link it
LOWERING, LINKING = {KERNEL: 17.0, DERIVATIVES: 16.0}, {KERNEL: 5.0, DERIVATIVES: 4.0}
# platform → [s] additional time of zig's first link for this platform, in which zig builds libraries of its
# own; 0 for all others
PREPARATION_TIMES = {"win64": 3.0}


def kernel_library(
    scope: KernelScope,
    platform: str = HOST,
    law_file: str = "",
    *,
    derivatives: bool = False,
) -> Path:
    """Return the path of a kernel for the scenes ``scope``: prebuilt, from the cache, or newly compiled.

    Args:
        scope: the scenes that the kernel must be able to run; it may also run other scenes.
        platform: a key of ``system.PLATFORMS``; "" if there is no kernel for this machine.
        law_file: the file of the user's law in the kernel; "" for none.
        derivatives: whether the kernel carries derivatives.

    Raises:
        BuildError: when the user's law or a compiler fails, when a kernel must be compiled without a
            compiler, or when there is no kernel for this machine.
    """
    if not platform:
        raise BuildError(no_kernel_sentence())
    law = _law(law_file) if law_file else None
    library_kind = DERIVATIVES if derivatives else KERNEL
    kernel_scope = prebuilt.exact_scope(scope, library_kind)
    name = prebuilt.library_name(kernel_scope, platform, _law_name(law) if law else "", library_kind)
    existing = (
        cache.find(name) if law else prebuilt.best_kernel(scope, platform, library_kind) or cache.find(name)
    )
    if existing:
        return existing
    prebuilt.require_compilers(_purpose(platform, law_file, derivatives))
    lowered_law = _lowered_law(law, law_file) if law else None

    def part_file(part: str) -> Path:
        def text() -> str:
            module = _lowered_kernel(part)
            is_prepared = compilers.zig_is_prepared(platform)
            seconds = LINKING[part] + (0.0 if is_prepared else PREPARATION_TIMES.get(platform, 0.0))
            log_once(f"linking the kernel for {platform}", seconds)
            return module

        return prebuilt.object_file(kernel_scope, platform, part, text)

    def link(file: Path) -> None:
        parts = [part_file(part) for part in prebuilt.LIBRARY_PARTS[library_kind]]
        with _naming_law_file(law_file):
            compilers.link(parts, file, platform, lowered_law)

    return cache.get_or_make(name, link)


def browser_module(law_file: str = "") -> Path:
    """Return the path of the kernel as a WebAssembly module, for any scene, without derivatives.

    Args:
        law_file: the file of the user's law in the kernel; "" for none.

    Raises:
        BuildError: as for ``kernel_library``, and when the law calls a function that the module does not
            have.
    """
    law = _law(law_file) if law_file else None
    name = f"{_law_name(law)}-{browser.MODULE}" if law else browser.MODULE
    existing = prebuilt.find(name) or cache.find(name)
    if existing:
        return existing
    prebuilt.require_compilers(
        f"{law_file}: a contact law of your own" if law_file else "a page that computes"
    )
    lowered_law = _lowered_law(law, law_file) if law else None

    def text() -> str:
        module = _lowered_kernel(KERNEL)
        log_once("linking the kernel for a browser", LINKING[KERNEL])
        return module

    def link(file: Path) -> None:
        compiled = prebuilt.browser_object_file(text)
        with _naming_law_file(law_file):
            browser.link(compiled, file, lowered_law)

    return cache.get_or_make(name, link)


def _lowered_kernel(part: str) -> str:
    """Return the text of a part of the kernel, KERNEL or DERIVATIVES, in LLVM's language.

    The text is that of ``prebuilt.lowered_kernel``, if it exists, for KERNEL; else from the cache, or newly
    lowered. The text fits all scenes: ``compilers.add_prelude`` adds the counts.
    """

    def lower(module: Path) -> None:
        log_once("compiling the kernel", LOWERING[part])
        compilers.lower(module, part)

    packed = prebuilt.lowered_kernel() if part == KERNEL else None
    return packed or cache.get_or_make(f"{part}.ll", lower).read_text()


def _lowered_law(law: UserLaw, file: str) -> Path:
    """Return the path of a user's law in LLVM's language: from the cache, or newly lowered.

    ``file`` is the law's file, for errors.
    """

    def lower(module: Path) -> None:
        # the law is lowered from the text that was checked, because the file may have changed since
        copy = module.with_name(f"{law.id}.py")
        copy.write_text(law.source, encoding="utf-8")
        with _naming_law_file(file):
            compilers.lower(module, "law", copy)

    return cache.get_or_make(f"{_law_name(law)}.ll", lower)


def _law(file: str) -> UserLaw:
    with _naming_law_file(file):
        return read_law(Path(file))


@contextmanager
def _naming_law_file(law_file: str) -> Iterator[None]:
    """Context manager that makes a LawError a BuildError, with the law's file in front of the message."""
    try:
        yield
    except LawError as error:
        raise BuildError(f"{law_file} {error}") from None


def _law_name(law: UserLaw) -> str:
    return f"{law.id}-{hashlib.sha256(law.source.encode()).hexdigest()[:16]}"


def _purpose(platform: str, law_file: str, derivatives: bool) -> str:
    if derivatives:
        return "a kernel that carries derivatives"
    if law_file:
        return f"{law_file}: a contact law of your own"
    return "this kernel" if platform == HOST else f"a kernel for {platform}"
