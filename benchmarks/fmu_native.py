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
from xml.etree import ElementTree

from chain_impact.compilation.cache import linker_folder
from chain_impact.compilation.compilers import INCLUDES
from chain_impact.fmu.build import build_fmu
from chain_impact.scene.scene import load_scene, with_values

SCENE, OUTPUTS, STEP, STEPS, ROUNDS = "four_link_box", 30, 1e-3, 2000, 31
INPUT = "joint[2].torque"
TARGETS = ("native", "pythonfmu")
HERE = Path(__file__).parent


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
    program = folder / "fmu_native"
    compiler = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-O2",
        *(f"-I{folder}" for folder in INCLUDES),
        str(HERE / "fmu_native.c"),
    ]
    folders = {"ZIG_GLOBAL_CACHE_DIR": str(linker_folder()), "ZIG_LOCAL_CACHE_DIR": str(folder / "zig")}
    subprocess.run([*compiler, "-o", str(program), "-ldl", "-lm"], check=True, env={**os.environ, **folders})
    places = []
    for target in TARGETS:
        unpacked = folder / f"unpacked {target}"
        with zipfile.ZipFile(fmus[target]) as archive:
            archive.extractall(unpacked)
        root = ElementTree.parse(unpacked / "modelDescription.xml").getroot()
        binary = unpacked / "binaries" / "linux64" / f"{root[0].get('modelIdentifier')}.so"
        places += [binary, root.get("guid"), (unpacked / "resources").as_uri()]
    # both kinds have the same value references
    every = {node.get("name"): node for node in root.iter("ScalarVariable")}
    reals = [n for n in every.values() if n.get("causality") == "output" and n[0].tag == "Real"]
    read = [node.get("valueReference") for node in reals[:OUTPUTS]]
    change = every[driven].get("valueReference") if driven else -1
    command = [program, python_library(), int(embeds), STEP, STEPS, ROUNDS, change, *places, *read]
    lines = subprocess.run(
        list(map(str, command)),
        check=True,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONHOME": sys.base_prefix},
    ).stdout
    names = [f"{target} {what}" for target in TARGETS for what in ("instance", "step")]
    numbers = [map(float, line.split()) for line in lines.splitlines()[1:]]  # the first round warms up
    return dict(zip([*names, "kernel"], map(list, zip(*numbers, strict=True)), strict=True))


def python_library() -> Path:
    """The library of the Python that runs this."""
    folder, name = (sysconfig.get_config_var(key) for key in ("LIBDIR", "INSTSONAME"))
    path = Path(folder) / name
    if not path.is_file() or ".so" not in path.suffixes:
        raise FileNotFoundError(
            f"{path}: a tool in C needs Python as a shared library (Debian's libpython3.11)"
        )
    return path


def in_fmpy(native: Path, by_pythonfmu: Path) -> dict:
    """The same scenario through ctypes pointers, for both kinds of FMU in turn."""
    command = [sys.executable, str(Path(__file__)), "measure", str(native), str(by_pythonfmu)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    found: dict = json.loads(done.stdout.splitlines()[-1])
    return found


def measure(native: str, by_pythonfmu: str) -> dict:
    """In a process of its own."""
    from fmu_importer import STEP, STOP, Importer, later_start, once, turns

    importers = {"native": Importer(native, OUTPUTS), "pythonfmu": Importer(by_pythonfmu, OUTPUTS)}
    results = {}
    for name, function, scale in (
        ("a step [µs]", once, 1e6 * STEP / STOP),
        ("instance [ms]", later_start, 1e3),
    ):
        for importer in importers.values():
            function(importer)
        timings = turns({who: lambda f=function, i=one: f(i) for who, one in importers.items()})
        results[name] = {who: common.median([scale * value for value in row]) for who, row in timings.items()}
        results[name]["pythonfmu / native"] = common.ratio(timings, "pythonfmu", "native")
    return results


def main() -> None:
    """Build, measure and save."""
    if sys.argv[1:2] == ["measure"]:
        print(json.dumps(measure(*sys.argv[2:])))
        return
    started = common.environment()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        fmus = {target: build_fmu(SCENE, folder / target, target=target) for target in TARGETS}
        native, by_pythonfmu = fmus.values()
        results = {
            "C": in_c(fmus, folder / "C") | in_c_driven(folder),
            "fmpy": in_fmpy(native, by_pythonfmu),
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
