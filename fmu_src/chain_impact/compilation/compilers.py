"""The two programs that make a library: numba's front end, run once, and zig's C compiler, run for each.

lower.py writes the kernel in LLVM's language, without sizes. The prelude has the sizes; the kernel is
compiled with it. Then the kernel is linked with the C interface of native FMUs (c_interface/), the same for
every scene, and with the functions that it leaves open: the hooks, which carry derivatives or do nothing, and
a user's contact law, or none.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Collection, Iterable
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

from chain_impact.compilation.cache import linker_folder
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.law_file import LawError
from chain_impact.compilation.sources import PACKAGE, fingerprint
from chain_impact.system import HOST, PLATFORMS

_TARGETS = {
    "linux64": "x86_64-linux-gnu.2.17",
    "win64": "x86_64-windows-gnu",
    "darwin64": "x86_64-macos.11.0",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "aarch64-darwin": "aarch64-macos.11.0",
}
ZIG_TARGETS = {name: (target, PLATFORMS[name].suffix) for name, target in _TARGETS.items()}
"""Platform → zig's target and the file suffix."""
PORTABLE_CPU = "x86-64-v2"
BAD_LAW = 3  # exit code of lower.py for a faulty law; the reason is on standard error
# For every x86 processor since 2009 and every 64-bit ARM, so that all processors of a kind give equal bits.
CPUS = {"x86_64": "x86_64_v2", "aarch64": "generic"}
KERNEL, DERIVATIVES = "kernel", "derivatives"
"""What is lowered and compiled by itself: the kernel, and the hooks that carry derivatives. Also the kinds of
libraries: the kernel, and the kernel with these hooks."""
# ARM's instruction that multiplies and adds is not used: it rounds once where the two instructions of x86
# round twice. Without LLVM's loop strength reduction, linking takes less time, and kernels are no slower.
FLAGS = ("-O2", "-ffp-contract=off", "-Wno-everything", "-mllvm", "-disable-lsr")
# Twice as much as usual is inlined, which makes steps of four links up to 4 % faster. Derivatives do without
# it: they would be no faster, and take longer to compile.
INLINE_MORE = ("-mllvm", "-inline-threshold=500")
# LLVM's vectors of straight code make runs of one link up to a tenth slower, and runs of two links a tenth
# faster.
SCALAR = ("-fno-slp-vectorize",)
# numba's code refers to these only on its error paths, which the kernel never takes because it does not
# allocate
PYTHON_SYMBOLS = ("NRT_MemInfo_call_dtor",)
INTERFACE = PACKAGE / "compilation" / "c_interface"
INCLUDES = tuple(INTERFACE / name for name in ("common", "fmi2", "fmi3"))
# Runs lower.py with these sources. The variable PYTHONPATH would not work: where pip builds a wheel, it hides
# the folder of an editable installation of the same sources.
LOWER = """import runpy, sys
sys.path.insert(0, sys.argv.pop(1))
runpy.run_module("chain_impact.compilation.lower", run_name="__main__", alter_sys=True)"""
# Parts of the C runtime that Windows has since version 10. Without them zig would first build its own, which
# takes a minute. Functions that Windows lacks are in zig's compiler-rt and in c_interface/common/windows.c.
WINDOWS_PARTS = ("convert", "heap", "math", "private", "stdio", "string")
GENERAL = 0
"""In place of a number of links: a kernel for any number of links and for all that few scenes have, such as
walls that move, points of links, a slider, or signals. The other kernels do without these at no cost."""
_FEW = tuple(f"chain_{name}" for name in ("channels", "sites", "signals", "knots", "skewed", "slides"))
_SIZES = ("chain_links", "chain_candidates", "chain_elements", "chain_loads", *_FEW)
"""The functions for the numbers at the start of a record, in their order there."""
Sizes = int | tuple[int, ...] | None
"""What a kernel is for: a number of links, None for any, GENERAL for any with all features; or all numbers at
the start of a record, for scenes of these very sizes."""
STUB = '__attribute__((visibility("hidden"))) void {}(void) {{}}\n'

# A number that the instance holds does not change while the kernel works on it, and has a sensible size.
HELD = """define internal i64 @{name}(ptr %instance) alwaysinline {{
  %place = getelementptr i64, ptr %instance, i64 {word}
  %number = load i64, ptr %place, align 8, !invariant.load !{{}}, !range !{{i64 0, i64 1048576}}
  ret i64 %number
}}
"""
CONSTANT = """define internal i64 @{name}(ptr %instance) alwaysinline {{
  ret i64 {number}
}}
"""
Open = dict[str, tuple[str, tuple[str, ...], int]]
"""What a kernel leaves open: C function → LLVM's types of its result and its arguments, and the result of the
function that stands for it where there is none. In numba, one that returns nothing returns a pointer."""
LAW: Open = {
    "user_law_present": ("i64", (), 0),
    "user_law_force": ("double", ("double",) * 7, 0),
}
_ON_INSTANCE = (
    "on_start",
    "on_reinit",
    "on_step",
    "on_observe",
    "on_observe_trial",
    "on_truncate",
)
HOOKS: Open = {
    **dict.fromkeys(_ON_INSTANCE, ("ptr", ("ptr",), 0)),
    "indices_valid": ("i64", ("ptr",), 1),
    "words_behind": ("i64", ("ptr",), 0),
}
REGISTERS = """declare hidden i64 @usual_registers()
declare hidden void @put_registers_back(i64)
"""
# WebAssembly has no such registers: it always computes in the usual way
NO_REGISTERS = """define internal i64 @usual_registers() alwaysinline {
  ret i64 0
}
define internal void @put_registers_back(i64 %registers) alwaysinline {
  ret void
}
"""
C_TYPES = {"i64": "long long", "double": "double", "ptr": "void *"}
_DECLARED_ABOVE = re.compile(
    r"^declare .*@(chain_\w+|usual_registers|put_registers_back)"
    r"\(.*$\n",
    re.M,
)
_LEFT_OPEN = re.compile(rf"^(declare|define) (?=[^\n]*@({'|'.join([*LAW, *HOOKS])})\()", re.M)
_OF_NUMBA = re.compile(r"undefined symbol: _?numba_(\w+)")


def complete(module: str, sizes: Sizes, registers: str = REGISTERS) -> str:
    """Return a lowered kernel with the functions that it leaves open.

    Args:
        module: the kernel in LLVM's language, as lower.py writes it.
        sizes: what it is for.
        registers: the functions that set the floating-point registers: declared, as the C interface has them,
            or those that do nothing.
    """
    if isinstance(sizes, tuple):
        fixed = dict(zip(_SIZES, sizes, strict=True))
    else:
        fixed = dict.fromkeys(() if sizes == GENERAL else _FEW, 0) | ({"chain_links": sizes} if sizes else {})
    prelude = "".join(
        CONSTANT.format(name=name, number=fixed[name]) if name in fixed else HELD.format(name=name, word=word)
        for word, name in enumerate(_SIZES)
    )
    hidden = _LEFT_OPEN.sub(r"\1 hidden ", module)  # private to a library, and called without a table
    return _DECLARED_ABOVE.sub("", hidden) + prelude + registers


def lower(module: Path, what: str, law: Path | None = None) -> None:
    """Write a part of a kernel in LLVM's language.

    Args:
        module: the file to write.
        what: KERNEL, DERIVATIVES, or "law".
        law: the file of the user's law, if it is that.

    Raises:
        LawError: when the law cannot be compiled.
        BuildError: when numba fails, or the sources are other ones by now.
    """
    # numba takes the features of this machine unless told otherwise, and orders by hash
    cpu = CPUS["aarch64"] if HOST.startswith("aarch64") else PORTABLE_CPU
    settings = {"NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": "", "PYTHONHASHSEED": "0"}
    given = [str(law)] if law else []
    done = _run("-c", LOWER, str(PACKAGE.parent), fingerprint(), str(module), what, *given, **settings)
    if done.returncode == BAD_LAW:
        raise LawError(done.stderr.splitlines()[-1])
    _check(done)


def compile_part(module: str, compiled: Path, platform: str, what: str, sizes: Sizes) -> None:
    """Compile a lowered part of a kernel, KERNEL or DERIVATIVES. What it leaves open, ``link`` adds.

    Args:
        module: the part in LLVM's language, as lower.py writes it.
        compiled: the file to write; temporary files are put beside it.
        platform: of ``ZIG_TARGETS``.
        what: the part.
        sizes: what it is for.

    Raises:
        BuildError: when the compiler fails.
    """
    kernel = compiled.with_name("kernel.ll")
    kernel.write_text(complete(module, sizes))
    flags = ["-c", *_tuning(what, sizes)]
    if "windows" not in ZIG_TARGETS[platform][0]:  # Windows code is always position-independent
        flags.append("-fPIC")
    _zig(platform, compiled, kernel, flags=flags)


def _tuning(what: str, sizes: Sizes) -> tuple[str, ...]:
    """Return the flags that make a part of a kernel for these sizes faster."""
    if what == DERIVATIVES:
        return ()
    links = sizes[0] if isinstance(sizes, tuple) else sizes
    return (*INLINE_MORE, *SCALAR) if links == 1 else INLINE_MORE


def link(parts: Collection[Path], library: Path, platform: str, law: Path | None = None) -> None:
    """Make the library of a kernel.

    Args:
        parts: the compiled kernel and, in one that carries derivatives, the compiled hooks.
        library: the file to write; temporary files are put beside it.
        platform: a key of ``ZIG_TARGETS``.
        law: a user's law in LLVM's language, if there is one.

    Raises:
        LawError: when the law calls a function that only numba has.
        BuildError: when the compiler fails.
    """
    prepare_zig(platform)
    try:
        beside = write_beside(library, law, derivatives=len(parts) > 1)
        _zig_library(platform, library, *parts, *interface_sources(), *beside)
    except BuildError as error:
        missing = _OF_NUMBA.search(str(error))
        if law and missing:
            raise LawError(f"calls {missing[1]}, which a kernel does not have") from None
        raise


def zig_is_prepared(platform: str) -> bool:
    """Return whether zig has already linked for a platform."""
    return (linker_folder() / f"prepared-{platform}").exists()


def prepare_zig(platform: str) -> None:
    """Make sure that zig has the libraries that it makes for itself at its first link for a platform.

    Later zig only reads these libraries, so several links can run at once.
    """
    if zig_is_prepared(platform):
        return
    from filelock import FileLock

    folder = linker_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with FileLock(folder / f"{platform}.lock"), TemporaryDirectory() as scratch:
        if not zig_is_prepared(platform):
            something = Path(scratch, "something.c")  # zig crashes at an empty library for macOS
            something.write_text(STUB.replace("hidden", "default").format("something"), encoding="utf-8")
            _zig_library(platform, Path(scratch, "library"), something)
            (folder / f"prepared-{platform}").touch()


def interface_sources() -> list[Path]:
    """Return the files of the C interface."""
    return sorted(INTERFACE.rglob("*.c"))


def _zig_library(platform: str, library: Path, *inputs: Path) -> None:
    """Compile the parts that are not compiled yet, and link a library."""
    target, _ = ZIG_TARGETS[platform]
    options = ["-shared", "-s"]
    if "linux" in target:
        # a called function must not be found in another library that the same process has loaded, nor be
        # missing
        options += ["-Wl,-Bsymbolic", "-Wl,-z,defs"]
    if "macos" in target:  # otherwise the library names the folder in which it was made
        options.append("-Wl,-install_name,@rpath/kernel.dylib")
    # Without start files and, except for Windows, zig's runtime, which it would first have to build. Nothing
    # calls them.
    libraries = ["-nostdlib", *(_from_windows() if "windows" in target else ["-lm", "-lc"])]
    _zig(platform, library, *inputs, flags=options, libraries=libraries)


def write_beside(library: Path, law: Path | None, *, derivatives: bool = False) -> tuple[Path, ...]:
    """What a kernel needs of others: a user's law, and functions that do nothing for all that is missing."""
    missing = ({} if derivatives else HOOKS) | ({"user_law_present": ("i64", (), 1)} if law else LAW)
    text = "".join(map(STUB.format, PYTHON_SYMBOLS))
    for name, (result, arguments, nothing) in missing.items():
        named = ", ".join(f"{C_TYPES[kind]} a{k}" for k, kind in enumerate(arguments)) or "void"
        text += f"{C_TYPES[result]} {name}({named}) {{ return ({C_TYPES[result]}){nothing}; }}\n"
    beside = library.with_name("beside.c")
    beside.write_text(text)
    return (law, beside) if law else (beside,)


def _zig(
    platform: str, output: Path, *inputs: Path, flags: Iterable[str], libraries: Iterable[str] = ()
) -> None:
    """Run zig's C compiler."""
    target, _ = ZIG_TARGETS[platform]
    options = ["cc", "-target", target, f"-mcpu={CPUS[target.partition('-')[0]]}", *FLAGS]
    options += ["-fvisibility=hidden", *flags]
    paths = map(str, (*(f"-I{folder}" for folder in INCLUDES), "-o", output, *inputs))
    run_zig([*options, *paths, *libraries], output)


def run_zig(arguments: Iterable[str], output: Path) -> None:
    """Run zig in a cache that no other program uses; temporary files are put beside the output.

    Raises:
        BuildError: when zig fails.
    """
    folders = {"ZIG_GLOBAL_CACHE_DIR": linker_folder(), "ZIG_LOCAL_CACHE_DIR": output.with_name("zig")}
    places = {name: str(path) for name, path in folders.items()}
    _check(_run("-m", "ziglang", *arguments, **places))


def _from_windows() -> list[str]:
    """Return zig's options for a library that takes C's functions from Windows, and for their headers."""
    headers = files("ziglang") / "lib" / "libc" / "include" / "any-windows-any"
    options = ["-Wl,--no-entry", "-rtlib=compiler-rt"]
    options += [f"-isystem{headers}", "-D__MSVCRT_VERSION__=0xE00"]
    return [*options, *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in WINDOWS_PARTS), "-lkernel32"]


def _run(*arguments: str, **settings: str) -> subprocess.CompletedProcess[str]:
    """Run Python independently of the user's settings of numba and of the files in the present folder."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    with TemporaryDirectory() as nowhere:
        return subprocess.run(
            [sys.executable, "-P", *arguments],
            cwd=nowhere,
            env=kept | settings,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            check=False,
        )


def _check(done: subprocess.CompletedProcess[str]) -> None:
    if done.returncode != 0:
        program = "zig" if "ziglang" in done.args else "numba"
        raise BuildError(f"could not compile the kernel: {program} said:\n{done.stderr}")
