"""What the native FMU costs, against the kernel alone and pythonfmu: ``python benchmarks/fmu_native.py``.

A tool in C (fmu_native.c) times the interface against the kernel's own functions, and the making of an
instance. fmpy times both FMUs in turn, in a process without this project's package (fmu_importer.py).
"""

from __future__ import annotations

import common  # isort: skip

import json
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from xml.etree import ElementTree

from chain_impact.compilation.cache import linker_folder
from chain_impact.compilation.compilers import INTERFACE
from chain_impact.export.fmu import build_fmu
from chain_impact.scene import load_scene, with_values

SCENE, OUTPUTS, STEP, STEPS, ROUNDS = "four_link_box", 30, 1e-3, 2000, 31
INPUT = "joint[2].torque"
HERE = Path(__file__).parent


def in_c(fmu: Path, folder: Path) -> dict:
    """What a tool in C sees."""
    rows = rounds_in_c(fmu, folder / "plain", "")
    return {
        "a step through FMI [ns]": common.median([row[0] for row in rows]),
        "a step of the kernel alone [ns]": common.median([row[1] for row in rows]),
        "the interface [ns]": common.median([row[0] - row[1] for row in rows]),
        "instantiate and initialise [µs]": common.median([row[2] / 1e3 for row in rows]),
    }


def in_c_driven(folder: Path) -> dict:
    """A step, if the torque at the first elbow changes before each; and if it does not, in the same FMU."""
    scene = with_values(load_scene(SCENE), {("inputs", "joint_torques"): True})
    fmu = build_fmu(scene, folder / "driven", target="native")
    driven, still = (rounds_in_c(fmu, folder / "driven", name) for name in (INPUT, ""))
    return {
        "a step with a changed input [ns]": common.median([row[0] for row in driven]),
        "a step with inputs that do not change [ns]": common.median([row[0] for row in still]),
    }


def rounds_in_c(fmu: Path, folder: Path, driven: str) -> list[tuple[float, ...]]:
    """What fmu_native.c prints, if it changes the input of this name, or none, before each step."""
    folder.mkdir(exist_ok=True)
    program, unpacked = folder / "fmu_native", folder / "unpacked"
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(unpacked)
    compiler = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-O2",
        "-I",
        str(INTERFACE),
        str(HERE / "fmu_native.c"),
    ]
    folders = {"ZIG_GLOBAL_CACHE_DIR": str(linker_folder()), "ZIG_LOCAL_CACHE_DIR": str(folder / "zig")}
    subprocess.run([*compiler, "-o", str(program), "-ldl", "-lm"], check=True, env={**os.environ, **folders})
    root = ElementTree.parse(unpacked / "modelDescription.xml").getroot()
    reals = [n for n in root.iter("ScalarVariable") if n.get("causality") == "output" and n[0].tag == "Real"]
    references = [node.get("valueReference") for node in reals[:OUTPUTS]]
    command = [program, unpacked / "binaries" / "linux64" / f"{root.get('modelName')}.so", root.get("guid")]
    every = {n.get("name"): n.get("valueReference") for n in root.iter("ScalarVariable")}
    command += [(unpacked / "resources").as_uri(), STEP, STEPS, ROUNDS]
    command += [every[driven] if driven else -1, *references]
    lines = subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True).stdout
    return [tuple(map(float, line.split())) for line in lines.splitlines()][1:]  # the first warms up


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
        native, by_pythonfmu = (
            build_fmu(SCENE, folder / target, target=target) for target in ("native", "pythonfmu")
        )
        results = {"C": in_c(native, folder) | in_c_driven(folder), "fmpy": in_fmpy(native, by_pythonfmu)}
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
