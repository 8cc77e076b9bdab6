"""Does chain-impact work on this machine? ``python packaging/smoke.py`` in an environment that has it.

It calls every public function once, and the command line, in a temporary folder, and needs no other file of
the repository. If an optional package is missing, the error of a function must name it. The kernels of all
kinds must give the same bits. ``--write FILE`` keeps the results, and ``--compare FILE`` says by how much
those of another machine differ. With ``--traps``, which needs Linux on x86-64, an invalid operation, a
division by zero or an overflow ends the process, as in a host that unmasks these exceptions. The command line
then runs in this process, because another process starts without traps.
"""

from __future__ import annotations

import argparse
import ctypes
import faulthandler
import io
import math
import os
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import chain_impact as ci
from chain_impact import console, system
from chain_impact.cli import main as main_of_command_line
from chain_impact.compilation import compilers, prebuilt
from chain_impact.fmu.build import TARGET
from chain_impact.simulation.kernels import kernel_for, load_kernel
from chain_impact.variables.prepared import PreparedScene

CHECKS: list[Callable[[], str | None]] = []
COMPILERS = all(find_spec(name) for name in ("numba", "llvmlite", "ziglang"))
ERRORS = (
    ci.AnimationError,
    ci.BuildError,
    ci.MissingExtraError,
    ci.RunError,
    ci.SceneError,
    ci.SimulationError,
)
MODELS = ("four_link_box", "rod_drop", "pinned_arm", "ramp")
SPRING = "def mine(penetration):\n    return 1e6 * penetration\n"
TABLE = "time,point[4].x\n" + "".join(f"{0.1 * i:.1f},{{}}\n" for i in range(4))

# the C library with the functions that set the rounding, and C's number for rounding upwards
C_LIBRARY = {"win64": "ucrtbase", "darwin64": "libSystem.B.dylib", "aarch64-darwin": "libSystem.B.dylib"}
UPWARDS = {"win64": 0x200, "linux64": 0x800, "darwin64": 0x800}


# C's numbers of the exceptions on x86-64: invalid operation, division by zero, overflow
TRAPPED = 0x1 | 0x4 | 0x8
# PyYAML, which dask imports, computes its infinity by an overflow during the import
TRAPPING_IMPORTS = ("pandas", "xarray", "dask.base")


def check(function: Callable[[], str | None]) -> Callable[[], str | None]:
    """Add a function to the list of checks; its result is printed."""
    CHECKS.append(function)
    return function


def run(*arguments: str, expected: int = 0) -> str:
    """Run the command line in a separate process, or in this one if it has traps; return the output.

    The exit code must be ``expected``, else the check fails with the output in its message.
    """
    if "--traps" in sys.argv:
        with redirect_stdout(io.StringIO()) as printed:
            try:
                code: object = main_of_command_line([*arguments])
            except SystemExit as stop:  # argparse's
                code = stop.code or 0
        assert code == expected, f"{arguments}: {code}\n{printed.getvalue()}"
        return printed.getvalue()
    command = [sys.executable, "-m", "chain_impact.cli", *arguments]
    done = subprocess.run(
        command, capture_output=True, text=True, encoding="utf-8", errors="replace", check=False
    )
    assert done.returncode == expected, f"{arguments}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def outputs_of(name: str) -> np.ndarray:
    """Return all outputs of a model during one second, shape (times, outputs)."""
    result = ci.simulate(ci.load_scene(name), stop_time=1.0, output_step=0.01)
    return np.column_stack([result[output] for output in result.names])


# --- simulation --------------------------------------------------------------------------------------------


@check
def kernels() -> str:
    assert system.HOST in system.PLATFORMS
    count = len(prebuilt.prebuilt_kernels())
    assert count or COMPILERS, "the kernels of the wheel are not those of its sources"
    return f"{system.HOST}, {count} prebuilt kernels, compilers: {'yes' if COMPILERS else 'no'}"


@check
def all_kinds_of_kernels_give_the_same_bits() -> str:
    scene, blocks = ci.load_scene("four_link_box"), {}
    for kind, size in (
        (compilers.KERNEL, 4),
        (compilers.KERNEL, compilers.AnyLinks.PLAIN),
        (compilers.DERIVATIVES, compilers.AnyLinks.PLAIN),
    ):
        found = prebuilt.find(prebuilt.library_name(size, system.HOST, library_kind=kind))
        if found is None:
            continue
        kernel, memory = load_kernel(found), PreparedScene(scene).new_instance()
        assert kernel.initialize(memory.ctypes.data, 0.0) == 0
        assert kernel.advance_to(memory.ctypes.data, 2.0) == 0
        assert kernel.observe_now(memory.ctypes.data) == 0
        assert memory[0]["impact"]["count"] > 1
        blocks[found.name] = memory.tobytes()
    assert len(set(blocks.values())) <= 1, f"not the same: {', '.join(blocks)}"
    return f"{len(blocks)} kernels"


@check
def a_process_that_rounds_upwards() -> None:
    scene, blocks = ci.load_scene("four_link_box"), []
    c, kernel = (
        ctypes.CDLL(C_LIBRARY.get(system.HOST, "libm.so.6")),
        kernel_for(scene, derivatives=False),
    )
    for rounding in (0, UPWARDS.get(system.HOST, 0x400000)):
        memory = PreparedScene(scene).new_instance()
        assert c.fesetround(rounding) == 0
        try:
            assert kernel.initialize(memory.ctypes.data, 0.0) == 0
            assert kernel.advance_to(memory.ctypes.data, 2.0) == 0
            assert kernel.observe_now(memory.ctypes.data) == 0
            assert c.fegetround() == rounding
        finally:
            c.fesetround(0)
        blocks.append(memory.tobytes())
    assert blocks[0] == blocks[1]


@check
def scenes() -> None:
    scene = ci.load_scene("rod_drop")
    assert isinstance(scene, ci.Scene)
    assert "four_link_box" in ci.model_names()
    text = 'name = "Rod"\n[chain]\nlinks = [{length = 0.3, mass = 0.2}]\n[box]\ny_min = 0.0\n[initial]\n'
    parsed = ci.parse_scene(text + "position = [0.0, 0.5]\nangles = [0.3]\n", "rod")
    assert len(ci.simulate(parsed, stop_time=0.5).impacts) > 0
    assert scene.with_values({"contact.restitution": 0.5}).contact.restitution == 0.5
    assert ci.with_values(scene, {("contact", "restitution"): 0.5}).contact.restitution == 0.5
    assert ci.sphere_plane_stiffness(0.02, 2e11, 0.3, 2e11, 0.3) > 0.0
    assert all(isinstance(law, ci.ContactLaw) for law in ci.CONTACT_LAWS.values())
    try:
        scene.with_values({"contact.stifness": 1.0})
    except ci.UnknownNameError as error:
        assert isinstance(error, ci.SceneError)
        assert "contact.stiffness" in str(error)
    else:
        raise AssertionError("an unknown name was taken")


@check
def results() -> None:
    result = ci.simulate(ci.load_scene("four_link_box"), stop_time=1.0)
    assert isinstance(result, ci.Result)
    assert result.impacts.dtype == ci.IMPACT_DTYPE
    assert result.stick_slip.dtype == ci.STICK_SLIP_DTYPE
    assert len(result.impacts) > 0
    assert (
        abs(result["energy.total"][-1] + result["energy.dissipated"][-1] - result["energy.total"][0]) < 1e-5
    )
    result.plot("motion.png")
    assert Path("motion.png").stat().st_size > 10_000
    for package, table in (("pandas", result.to_dataframe), ("xarray", result.to_xarray)):
        try:
            assert table() is not None
        except ci.MissingExtraError:
            assert not find_spec(package)
    driven = ci.simulate(ci.load_scene("pinned_arm"), stop_time=0.2, inputs={"joint[1].torque": math.sin})
    assert driven.statistics


@check
def steps_by_hand() -> None:
    chain = ci.Chain(ci.load_scene("four_link_box"))
    chain.step_to(0.3)
    state = chain.save()
    chain.step(0.4)
    first = chain.get(["point[4].x"])
    chain.restore(state)
    chain.step(0.4)
    assert chain.get(["point[4].x"]) == first
    assert len(chain.impacts) > 0


@check
def derivatives() -> str:
    scene = ci.load_scene("four_link_box")
    try:
        result = ci.simulate(scene, stop_time=0.6, sensitivities=["contact.restitution"])
    except ci.BuildError as error:
        assert "compiler" in str(error) and not COMPILERS
        return "no kernel with derivatives is ready, and no compiler is installed"
    exact = float(result.sensitivity("point[4].x", "contact.restitution")[-1])
    ends = [
        ci.simulate(scene.with_values({"contact.restitution": 0.7 + step}), stop_time=0.6)["point[4].x"][-1]
        for step in (1e-5, -1e-5)
    ]
    assert abs((ends[0] - ends[1]) / 2e-5 - exact) < 1e-3 * max(1.0, abs(exact))
    return f"d x/d e = {exact:.6f} m"


@check
def sweeps() -> None:
    scene = ci.load_scene("rod_drop")
    table = ci.sweep(scene, {"contact.restitution": "0.1:0.9:9"}, path=Path("sweep.csv"))
    assert isinstance(table, ci.Sweep)
    assert len(Path("sweep.csv").read_text(encoding="utf-8").splitlines()) == 10
    assert {file.name for file in Path().iterdir() if "sweep" in file.name} == {"sweep.csv"}


@check
def laws_side_by_side() -> None:
    found = ci.compare(ci.load_scene("rod_drop"), laws=["hertz", "flores"])
    assert isinstance(found, ci.Comparison)
    assert all(isinstance(one, ci.LawRun) for one in found.runs)


@check
def fits() -> str | None:
    scene = ci.load_scene("four_link_box")
    x = ci.simulate(scene, stop_time=0.3, output_step=0.1)["point[4].x"]
    Path("measured.csv").write_text(TABLE.format(*x), encoding="utf-8")
    start = scene.with_values({"initial.vx": 1.4})
    try:
        found = ci.fit(start, "measured.csv", ["initial.vx"])
    except (ci.MissingExtraError, ci.BuildError) as error:
        return str(error)
    assert isinstance(found, ci.Fit)
    assert abs(found.scene.initial.velocity[0] - 1.5) < 1e-6
    return None


@check
def animations() -> None:
    recording = ci.record_slowly(ci.load_scene("rod_drop").with_values({"simulation.stop_time": 0.5}))
    assert isinstance(recording, ci.Recording)
    ci.animate(recording, Path("motion.html"))
    ci.animate(recording, Path("motion.gif"), size=(320, 180))
    assert Path("motion.html").stat().st_size > 10_000 < Path("motion.gif").stat().st_size


@check
def a_law_of_ones_own() -> str | None:
    Path("mine.py").write_text(SPRING, encoding="utf-8")
    values = {"contact.law_file": "mine.py", "contact.model": "mine"}
    try:
        result = ci.simulate(ci.load_scene("rod_drop").with_values(values), stop_time=0.5)
    except ci.BuildError as error:
        assert not COMPILERS, error
        return str(error)
    assert len(result.impacts) > 0
    return None


# --- FMUs --------------------------------------------------------------------------------------------------


@check
def fmus() -> str:
    scene = ci.load_scene("rod_drop").with_values({"simulation.stop_time": 0.5})
    expected = ci.simulate(scene)["point[0].y"]
    kinds: dict[str, tuple[int, ...]] = {TARGET: (2,), "native": (2, 3)}
    for target, versions in kinds.items():
        for version in versions:
            fmu = ci.build_fmu(scene, f"{target}{version}", target=target, fmi=version)
            assert ci.validate_fmu(fmu) == []
            recording = ci.record_fmu(fmu)
            assert np.array_equal(recording.columns["point[0].y"], expected), f"{target}, FMI {version}"
            assert len(ci.impacts_of({**recording.columns, "time": recording.time})) >= 0
    return ", ".join(f"{target} {' and '.join(map(str, versions))}" for target, versions in kinds.items())


@check
def pages_that_simulate() -> None:
    ci.explore("rod_drop", "rod_page.html")
    assert "WebAssembly" in Path("rod_page.html").read_text(encoding="utf-8")


@check
def the_command_line() -> None:
    assert "impact" in run("simulate", "rod_drop", "--plot", "rod.png", "--csv", "rod.csv")
    run("build", "rod_drop", "--simulate")
    run("build", "rod_drop", "--fmi", "3", "-o", "three")
    assert system.HOST in run("info", "build/RodDrop.fmu")
    assert "no problems found" in run("validate", "build/RodDrop.fmu")
    assert Path("build/RodDrop.png").is_file()
    run("animate", "rod_drop", "-o", "rod.html")
    run("explore", "rod_drop", "-o", "page.html")
    run("compare", "rod_drop", "--laws", "hertz,flores", "--plot", "laws.png")
    run(
        "sweep", "rod_drop", "--vary", "contact.restitution=0.1:0.9:3", "-o", "rows.csv", "--plot", "rows.png"
    )
    run("cache")
    assert "chain-impact" in run("completion", "bash")
    run("simulate", "no_such_scene", expected=2)
    run("--version")


# --- all of it ---------------------------------------------------------------------------------------------


def compared(file: Path) -> str:
    """Return the deviations of results from those in a file, relative to the largest value of each output."""
    found = []
    with np.load(file) as other:
        for name in MODELS:
            here, there = outputs_of(name), other[name]
            size = np.maximum(np.abs(there).max(axis=0), 1e-300)
            worst = float((np.abs(here - there) / size).max())
            found.append(f"{name} {'the same bits' if np.array_equal(here, there) else f'{worst:.1e}'}")
    return ", ".join(found)


def trap() -> None:
    """End the process at a floating-point exception, except in imports of other packages."""
    for package in TRAPPING_IMPORTS:
        with suppress(ImportError):
            import_module(package)
    faulthandler.enable()  # prints where a crashed process was
    assert ctypes.CDLL("libm.so.6").feenableexcept(TRAPPED) == 0
    print("with traps")


def main() -> int:
    """Call all checks; return the number of failed checks."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", type=Path, metavar="FILE", help="keep the results (npz)")
    parser.add_argument("--compare", type=Path, metavar="FILE", help="with results of another machine")
    parser.add_argument("--traps", action="store_true", help="end at a floating-point exception")
    options = parser.parse_args()
    console.prepare_console()
    os.environ.setdefault("MPLBACKEND", "Agg")
    files = [file.absolute() if file else None for file in (options.write, options.compare)]
    if options.traps:
        trap()
    failed, here = 0, Path.cwd()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as scratch:
        os.chdir(scratch)
        for one in CHECKS:
            started = time.process_time()
            try:
                said = one() or ""
            except Exception:
                failed, said = failed + 1, f"FAILED\n{traceback.format_exc()}"
            name = one.__name__.replace("_", " ")
            print(f"{name:42} {time.process_time() - started:6.1f} s  {said}", flush=True)
        if files[0]:
            save: Any = np.savez  # the names of its options differ between versions of NumPy
            save(files[0], **{name: outputs_of(name) for name in MODELS})
        if files[1]:
            print(f"against {files[1].name}: {compared(files[1])}")
        os.chdir(here)
    print(f"{failed} of {len(CHECKS)} checks failed")
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
