"""What the native FMU costs, against the kernel alone and pythonfmu: ``python benchmarks/fmu_native.py``.

A tool in C (fmu_native.c) times both kinds of FMU in turn, and the kernel's own functions; it loads libpython
for the FMU by pythonfmu. fmpy times both, too, in a process without this project's package (fmu_importer.py).
"""

from __future__ import annotations

import common  # isort: skip

import json
import os
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

from fmpy import read_model_description
from functions_library import zig

from chain_impact.compilation.compilers import INCLUDES
from chain_impact.fmu.build import build_fmu
from chain_impact.scene.scene import load_scene, with_values
from tests.fmu.interface import unpacked

SCENE, OUTPUTS, STEP, STEPS, ROUNDS = "four_link_box", 30, 1e-3, 2000, 31
INPUT = "joint[2].torque"
TARGETS = ("native", "pythonfmu")


def in_c(fmus: dict[str, Path], folder: Path) -> dict:
    """What a tool in C sees of either kind of FMU, and what the kernel takes of a native one's step."""
    without, rows = (rounds_in_c(fmus, folder, embeds=embeds) for embeds in (False, True))
    return {
        "a step, without a Python of its own [µs]": both(without, "step", 1e-3),
        "a step [µs]": both(rows, "step", 1e-3),
        "instance [ms]": both(rows, "instance", 1e-6),
        "a step of the kernel alone [ns]": common.median(rows["kernel"]),
        "the native interface [ns]": common.median(
            [step - kernel for step, kernel in zip(rows["native step"], rows["kernel"], strict=True)]
        ),
    }


def in_c_driven(folder: Path) -> dict:
    """A step, if the torque at the first elbow changes before each; and if it does not, in the same FMU."""
    scene = with_values(load_scene(SCENE), {("inputs", "joint_torques"): True})
    fmus = {target: build_fmu(scene, folder / "driven" / target, target=target) for target in TARGETS}
    return {
        f"a step with {what} [µs]": both(rounds_in_c(fmus, folder / "driven", driven=name), "step", 1e-3)
        for what, name in (("a changed input", INPUT), ("inputs that do not change", ""))
    }


def both(rows: common.Timings, what: str, scale: float) -> dict:
    """The medians of both kinds of FMU, and their ratio."""
    timings = {target: rows[f"{target} {what}"] for target in TARGETS}
    return {
        **{target: common.median([scale * value for value in row]) for target, row in timings.items()},
        "pythonfmu / native": common.ratio(timings, "pythonfmu", "native"),
    }


def rounds_in_c(
    fmus: dict[str, Path], folder: Path, *, driven: str = "", embeds: bool = True
) -> common.Timings:
    """What fmu_native.c prints [ns].

    Args:
        fmus: target → FMU.
        folder: for what is compiled and unpacked.
        driven: the name of an input that changes before each step, if one does.
        embeds: whether the tool itself starts Python.
    """
    folder.mkdir(exist_ok=True)
    places: list[object] = []
    for target in TARGETS:
        place = unpacked(str(fmus[target]), str(folder / f"unpacked {target}"))
        description = read_model_description(str(place))
        binary = place / "binaries" / "linux64" / f"{description.coSimulation.modelIdentifier}.so"
        places += [binary, description.guid, (place / "resources").as_uri()]
    # both kinds have the same value references
    variables = description.modelVariables
    read = [v.valueReference for v in variables if v.causality == "output" and v.type == "Real"][:OUTPUTS]
    change = next((v.valueReference for v in variables if v.name == driven), -1)
    command = [tool(folder), python_library(), int(embeds), STEP, STEPS, ROUNDS, change, *places, *read]
    environment = {**os.environ, "PYTHONHOME": sys.base_prefix}
    done = subprocess.run(
        [*map(str, command)], check=True, stdout=subprocess.PIPE, text=True, env=environment
    )
    names = [f"{target} {what}" for target in TARGETS for what in ("instance", "step")]
    numbers = [map(float, line.split()) for line in done.stdout.splitlines()[1:]]  # the first round warms up
    return dict(zip([*names, "kernel"], map(list, zip(*numbers, strict=True)), strict=True))


def tool(folder: Path) -> Path:
    """The program of fmu_native.c, compiled in a folder."""
    program = folder / "fmu_native"
    headers = [f"-I{place}" for place in INCLUDES]
    zig(folder, *headers, Path(__file__).with_suffix(".c"), "-o", program, "-ldl", "-lm")
    return program


def python_library() -> Path:
    """The library of the Python that runs this."""
    folder, name = (sysconfig.get_config_var(key) for key in ("LIBDIR", "INSTSONAME"))
    path = Path(folder) / name
    if not path.is_file() or ".so" not in path.suffixes:
        raise FileNotFoundError(
            f"{path}: a tool in C needs Python as a shared library (Debian's libpython3.11)"
        )
    return path


def in_fmpy(fmus: dict[str, Path]) -> dict:
    """The same scenario through ctypes pointers, in a process that knows nothing of this project."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    script, named = Path(__file__).with_name("fmu_importer.py"), [f"{n}={path}" for n, path in fmus.items()]
    command = [sys.executable, str(script), str(OUTPUTS), *named]
    done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def main() -> None:
    """Build, measure and save."""
    started = common.environment()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        fmus = {target: build_fmu(SCENE, folder / target, target=target) for target in TARGETS}
        native, by_pythonfmu = fmus.values()
        results = {
            "C": in_c(fmus, folder / "C") | in_c_driven(folder),
            "fmpy": in_fmpy(fmus),
        }
        with zipfile.ZipFile(native) as fmu:
            binary = fmu.getinfo("binaries/linux64/FourLinkBox.so")
        results["bytes"] = {
            "native FMU": native.stat().st_size,
            "its binary, packed": binary.compress_size,
            "pythonfmu FMU": by_pythonfmu.stat().st_size,
        }
    print(json.dumps(results, indent=1, ensure_ascii=False))
    settings = {"scene": f"{SCENE}, {STEPS} steps of {STEP} s", "outputs read": OUTPUTS, "rounds": ROUNDS}
    common.save("fmu_native", started, settings, results)


if __name__ == "__main__":
    main()
