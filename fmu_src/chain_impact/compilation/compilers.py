"""The two programs that make a library: numba's front end, which writes LLVM code, and zig's C compiler.

numba lowers the kernel once (lower.py), without counts; ``add_prelude`` adds LLVM code with the counts.
zig compiles the kernel, and links it with two kinds of other code. The C interface of native FMUs
(c_interface/) is the same for every scene. The functions that the kernel declares but does not define are the
hooks (kernel/hooks.py), which carry derivatives or do nothing, and a user's contact law or a substitute.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Collection, Iterable
from enum import Enum
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

from chain_impact.compilation.cache import linker_folder
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.sources import PACKAGE, fingerprint
from chain_impact.kernel import hooks
from chain_impact.kernel.record.counts import COUNTS, FEATURES, LARGEST_COUNT
from chain_impact.system import HOST, PLATFORMS, X86
from chain_impact.user_laws.law_syntax import LawError

PORTABLE_CPU = X86.replace("_", "-")  # LLVM's name of the oldest x86 processors on which the code runs
BAD_LAW = 3  # exit code of lower.py for a law with a fault; the last line on standard error tells the fault
KERNEL, DERIVATIVES = "kernel", "derivatives"
"""The two parts of a kernel, which are lowered and compiled separately: the kernel itself, and the functions
that replace those of kernel/hooks.py and carry derivatives. As the kind of a library, KERNEL means a library
of the first part, without derivatives; DERIVATIVES means a library of both parts."""
# No fused multiply-add: ARM's instruction rounds once, the two instructions of x86 round twice, so results
# would differ in their bits. No loop strength reduction: without it linking takes less time, and kernels are
# no slower.
C_FLAGS = ("-O2", "-ffp-contract=off", "-Wno-everything", "-mllvm", "-disable-lsr")
# A limit for inlining of about twice LLVM's usual limit makes steps of four links up to 4 % faster. The part
# DERIVATIVES keeps the usual limit: with the larger limit it would be no faster, and would take longer to
# compile.
INLINE_MORE = ("-mllvm", "-inline-threshold=500")
# Vector instructions outside loops make runs of one link up to a tenth slower, but runs of two links a tenth
# faster. So only the kernel for one link is compiled without them.
SCALAR = ("-fno-slp-vectorize",)
# Functions of numba that lowered code calls only to free memory. The kernel allocates no memory, so these
# functions are never called, and empty substitutes are linked in their place.
PYTHON_SYMBOLS = ("NRT_MemInfo_call_dtor",)
INTERFACE = PACKAGE / "compilation" / "c_interface"
INCLUDES = tuple(INTERFACE / name for name in ("common", "fmi2", "fmi3"))
# A Python program that runs lower.py; its first argument is the folder that contains this package. PYTHONPATH
# cannot name this folder: where pip builds a wheel, pip hides the folder of an editable installation.
LOWER = """import runpy, sys
sys.path.insert(0, sys.argv.pop(1))
runpy.run_module("chain_impact.compilation.lower", run_name="__main__", alter_sys=True)"""
# The parts of the C runtime that Windows has since version 10. Without this list, zig would first build parts
# of its own, which takes a minute. Functions that Windows lacks are in zig's compiler-rt and in
# c_interface/common/windows.c.
WINDOWS_PARTS = ("convert", "heap", "math", "private", "stdio", "string")
_SIZES = tuple(f"chain_{name}" for name in (*COUNTS, *FEATURES))
"""The names of the LLVM functions that return the counts and flags at the start of a record, in the record's
order."""
_RARE_SIZES = _SIZES[COUNTS.index("channel_count") :]
"""The last names in _SIZES: those of the functions that return counts and flags of rare features. In kernels
for a number of links, or for ``AnyLinks.PLAIN``, these functions return 0."""


class AnyLinks(Enum):
    """The scenes of a kernel for any number of links; each value is a part of the kernel's file name.

    Rare features are, for example, moving walls, points of links, a slider, or signals. Runs with a kernel
    without them take less time.
    """

    PLAIN = "any"
    """Scenes without rare features."""
    GENERAL = "general"
    """All scenes."""


KernelScope = int | tuple[int, ...] | AnyLinks
"""The scenes that a kernel can run. A number: those with this number of links and without rare features; a
tuple: those with these counts and flags, in the order at the start of a record; else those of AnyLinks."""
# C code of a function that does nothing; the first braces stand for the name of the function
STUB_CODE = '__attribute__((visibility("hidden"))) void {}(void) {{}}\n'

# LLVM code of a function that reads a count or flag from the record. LLVM is told that the number does not
# change while the kernel runs, and is at least 0 and less than ``end``.
READ_COUNT_CODE = """define internal i64 @{name}(ptr %instance) alwaysinline {{
  %place = getelementptr i64, ptr %instance, i64 {word}
  %number = load i64, ptr %place, align 8, !invariant.load !{{}}, !range !{{i64 0, i64 {end}}}
  ret i64 %number
}}
"""
FIXED_COUNT_CODE = """define internal i64 @{name}(ptr %instance) alwaysinline {{
  ret i64 {number}
}}
"""
OpenFunctions = dict[str, tuple[str, tuple[str, ...], int]]
"""Name of a C function that a kernel calls but does not contain → LLVM's types of the result and of the
arguments, and the number that the function's substitute returns (``write_stubs``). numba declares a function
without a result as one that returns a pointer ("ptr")."""
LAW: OpenFunctions = {
    "user_law_present": ("i64", (), 0),
    "user_law_force": ("double", ("double",) * 7, 0),
}
HOOKS: OpenFunctions = {
    **{name: ("ptr", ("ptr",), 0) for name in vars(hooks) if name.startswith("on_")},
    "are_tangents_sound": ("i64", ("ptr",), 1),
    "tangent_words": ("i64", ("ptr",), 0),
}
REGISTERS = """declare hidden i64 @usual_registers()
declare hidden void @put_registers_back(i64)
"""
# The functions of REGISTERS for WebAssembly, which do nothing: WebAssembly has no registers with settings of
# floating-point arithmetic, and always computes with the usual settings.
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
_MISSING_NUMBA_SYMBOL = re.compile(r"undefined symbol: _?numba_(\w+)")


def add_prelude(module: str, scope: KernelScope, registers: str = REGISTERS) -> str:
    """Return the text of a lowered part of a kernel, with functions that the part only declares.

    Added are the functions that return the counts and flags at the start of a record, each as a constant or
    read from the record, and the text ``registers``. The functions of LAW and HOOKS are not added, but made
    hidden, so that calls of them are faster.

    Args:
        module: the text of the part in LLVM's language, as lower.py writes it.
        scope: the scenes that the kernel can run; they decide which counts are constants.
        registers: LLVM code for the functions of registers.c: REGISTERS or NO_REGISTERS.
    """
    if isinstance(scope, tuple):
        fixed = dict(zip(_SIZES, scope, strict=True))
    else:
        fixed = dict.fromkeys(() if scope is AnyLinks.GENERAL else _RARE_SIZES, 0)
        fixed |= {"chain_link_count": scope} if isinstance(scope, int) else {}
    prelude_code = "".join(
        FIXED_COUNT_CODE.format(name=name, number=fixed[name])
        if name in fixed
        else READ_COUNT_CODE.format(name=name, word=word, end=LARGEST_COUNT + 1)
        for word, name in enumerate(_SIZES)
    )
    # a hidden function is private to a library, so a call of it is direct, not through a table of addresses
    hidden_module = _LEFT_OPEN.sub(r"\1 hidden ", module)
    return _DECLARED_ABOVE.sub("", hidden_module) + prelude_code + registers


def lower(module: Path, part: str, law: Path | None = None) -> None:
    """Lower a part of a kernel to LLVM's language, in a process of its own.

    Args:
        module: the file to write.
        part: KERNEL, DERIVATIVES, or "law".
        law: the file of the user's law if ``part`` is "law", else None.

    Raises:
        LawError: when the law cannot be compiled.
        BuildError: when numba fails, or the sources have changed while the process ran.
    """
    # Without these settings, numba would write code for this machine's processor, in the order of hashes,
    # which differ in each run of Python: the code would differ between machines and between runs.
    settings = {
        "NUMBA_CPU_NAME": PLATFORMS[HOST].cpu.replace("_", "-"),
        "NUMBA_CPU_FEATURES": "",
        "PYTHONHASHSEED": "0",
    }
    law_arguments = [str(law)] if law else []
    process = _run(
        "-c", LOWER, str(PACKAGE.parent), fingerprint(), str(module), part, *law_arguments, **settings
    )
    if process.returncode == BAD_LAW:
        raise LawError(process.stderr.splitlines()[-1])
    _check(process)


def compile_part(module: str, compiled: Path, platform: str, part: str, scope: KernelScope) -> None:
    """Compile a lowered part of a kernel to an object file.

    Args:
        module: the text of the part in LLVM's language, as lower.py writes it.
        compiled: the object file to write; temporary files are in the same folder.
        platform: a key of ``PLATFORMS``.
        part: KERNEL or DERIVATIVES.
        scope: the scenes that the kernel can run; counts that are equal in all of them become constants.

    Raises:
        BuildError: when the compiler fails.
    """
    kernel = compiled.with_name("kernel.ll")
    kernel.write_text(add_prelude(module, scope))
    flags = ["-c", *_tuning_flags(part, scope)]
    if "windows" not in PLATFORMS[platform].target:  # code for Windows does not need the flag -fPIC
        flags.append("-fPIC")
    _compile_with_zig(platform, compiled, kernel, flags=flags)


def _tuning_flags(part: str, scope: KernelScope) -> tuple[str, ...]:
    """Return the compiler's flags for the speed of ``part`` of a kernel for the scenes ``scope``."""
    if part == DERIVATIVES:
        return ()
    links = scope[0] if isinstance(scope, tuple) else scope
    return (*INLINE_MORE, *SCALAR) if links == 1 else INLINE_MORE


def link(parts: Collection[Path], library: Path, platform: str, law: Path | None = None) -> None:
    """Link the compiled parts of a kernel to a shared library, with the C interface of FMUs.

    Args:
        parts: the compiled kernel and, for a library that carries derivatives, the compiled functions that
            replace those of kernel/hooks.py.
        library: the library to write; temporary files are in the same folder.
        platform: a key of ``PLATFORMS``.
        law: the file with a user's law in LLVM's intermediate language, or None.

    Raises:
        LawError: when the law calls a function of numba, which a kernel does not have.
        BuildError: when the compiler fails.
    """
    prepare_zig(platform)
    try:
        stub_files = write_stubs(library, law, derivatives=len(parts) > 1)
        link_library(platform, library, *parts, *interface_sources(), *stub_files)
    except BuildError as error:
        missing_symbol = _MISSING_NUMBA_SYMBOL.search(str(error))
        if law and missing_symbol:
            raise LawError(f"calls {missing_symbol[1]}, which a kernel does not have") from None
        raise


def zig_is_prepared(platform: str) -> bool:
    """Return whether zig has built the libraries that it needs to link for a platform."""
    return (linker_folder() / f"prepared-{platform}").exists()


def prepare_zig(platform: str) -> None:
    """Let zig build the libraries that it needs to link for a platform, unless it has built them.

    After that, linking only reads these libraries, so several processes can link at the same time.
    """
    if zig_is_prepared(platform):
        return
    from filelock import FileLock

    folder = linker_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with FileLock(folder / f"{platform}.lock"), TemporaryDirectory() as scratch:
        if not zig_is_prepared(platform):
            # the library must contain code, because zig crashes at an empty library for macOS
            something = Path(scratch, "something.c")
            something.write_text(STUB_CODE.replace("hidden", "default").format("something"), encoding="utf-8")
            link_library(platform, Path(scratch, "library"), something)
            (folder / f"prepared-{platform}").touch()


def interface_sources() -> list[Path]:
    """Return the sorted C files of the interface of FMUs, without headers."""
    return sorted(INTERFACE.rglob("*.c"))


def link_library(platform: str, library: Path, *inputs: Path) -> None:
    """Compile those inputs that are sources, and link all inputs to a shared library for a platform."""
    target = PLATFORMS[platform].target
    # -Os compiles the C interface for size, because it takes little time beside the kernel. The object file
    # of the kernel is already optimized for speed.
    options = ["-shared", "-s", "-Os"]
    if "linux" in target:
        # a call must find its function in this library, not in another library of the process; a function
        # that is missing is an error
        options += ["-Wl,-Bsymbolic", "-Wl,-z,defs"]
    # without this option the library would contain the name of the folder in which it was made
    if "macos" in target:
        options.append("-Wl,-install_name,@rpath/kernel.dylib")
    # Start files are left out, because nothing calls them. zig's runtime is left out, too, because zig would
    # first have to build it; only a library for Windows needs this runtime.
    libraries = ["-nostdlib", *(_windows_flags() if "windows" in target else ["-lm", "-lc"])]
    _compile_with_zig(platform, library, *inputs, flags=options, libraries=libraries)


def write_stubs(library: Path, law: Path | None, *, derivatives: bool = False) -> tuple[Path, ...]:
    """Write a C file with substitutes for functions that a kernel lacks; return the files to link with it.

    The C file has the functions of PYTHON_SYMBOLS and, without ``derivatives``, those of HOOKS. Without a
    ``law``, it has those of LAW; with a law, it has of these only ``user_law_present``, which returns 1. The
    files to link are the law, if there is one, and the C file, which is in the folder of ``library``.
    """
    missing_functions = ({} if derivatives else HOOKS) | (
        {"user_law_present": ("i64", (), 1)} if law else LAW
    )
    text = "".join(map(STUB_CODE.format, PYTHON_SYMBOLS))
    for name, (result, arguments, stub_result) in missing_functions.items():
        parameters_code = ", ".join(f"{C_TYPES[kind]} a{k}" for k, kind in enumerate(arguments)) or "void"
        text += (
            f"{C_TYPES[result]} {name}({parameters_code}) {{ return ({C_TYPES[result]}){stub_result}; }}\n"
        )
    stub_file = library.with_name("beside.c")
    stub_file.write_text(text)
    return (law, stub_file) if law else (stub_file,)


def _compile_with_zig(
    platform: str, output: Path, *inputs: Path, flags: Iterable[str], libraries: Iterable[str] = ()
) -> None:
    """Run zig's C compiler for a platform, with C_FLAGS and ``flags``, to make ``output`` of ``inputs``."""
    options = ["cc", "-target", PLATFORMS[platform].target, f"-mcpu={PLATFORMS[platform].cpu}", *C_FLAGS]
    options += ["-fvisibility=hidden", *flags]
    paths = map(str, (*(f"-I{folder}" for folder in INCLUDES), "-o", output, *inputs))
    run_zig([*options, *paths, *libraries], output)


def run_zig(arguments: Iterable[str], output: Path) -> None:
    """Run zig with a cache that no other program uses; temporary files are in the folder of ``output``.

    Raises:
        BuildError: when zig fails.
    """
    folders = {"ZIG_GLOBAL_CACHE_DIR": linker_folder(), "ZIG_LOCAL_CACHE_DIR": output.with_name("zig")}
    folder_texts = {name: str(path) for name, path in folders.items()}
    _check(_run("-m", "ziglang", *arguments, **folder_texts))


def _windows_flags() -> list[str]:
    """Return zig's options for a library that uses the C functions and headers of Windows."""
    headers = files("ziglang") / "lib" / "libc" / "include" / "any-windows-any"
    options = ["-Wl,--no-entry", "-rtlib=compiler-rt"]
    options += [f"-isystem{headers}", "-D__MSVCRT_VERSION__=0xE00"]
    return [*options, *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in WINDOWS_PARTS), "-lkernel32"]


def _run(*arguments: str, **settings: str) -> subprocess.CompletedProcess[str]:
    """Run Python without the user's settings of numba, and without modules from the present folder.

    ``arguments`` are those of Python, ``settings`` additional environment variables. The result has the exit
    code, which is not checked (``_check``), and the output as text.
    """
    kept_settings = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    with TemporaryDirectory() as nowhere:
        return subprocess.run(
            [sys.executable, "-P", *arguments],
            cwd=nowhere,
            env=kept_settings | settings,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            check=False,
        )


def _check(process: subprocess.CompletedProcess[str]) -> None:
    """Raise a BuildError with the program's messages if numba or zig has failed."""
    if process.returncode != 0:
        program = "zig" if "ziglang" in process.args else "numba"
        raise BuildError(f"could not compile the kernel: {program} said:\n{process.stderr}")
