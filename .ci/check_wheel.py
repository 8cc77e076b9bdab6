"""The wheel, installed outside of the repository by uv in every supported Python that is here.

Also as a tool, by ``uv tool`` and by pipx, which calls pip.

``python .ci/check_wheel.py SCRATCH``, in the repository. A wheel takes its kernels from the cache that
``CHAIN_IMPACT_CACHE`` names, or compiles them.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

SUPPORTED = ["python3.11", "python3.12", "python3.13", "python3.14"]
UV, PIPX = (Path(sys.executable).with_name(name) for name in ("uv", "pipx"))
CHECK = "import chain_impact, sys; assert sys.prefix in chain_impact.__file__; print(chain_impact.__file__)"


def run(*command: str | Path, **options: object) -> None:
    """Run a command, which has to succeed."""
    subprocess.run([str(part) for part in command], check=True, **options)  # type: ignore[call-overload]


def pythons() -> list[str]:
    """Return the supported Pythons on this machine: pyenv's Pythons, and those on the path."""
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"), "versions")
    path = os.pathsep.join([*map(str, sorted(kept.glob("*/bin"))), os.environ["PATH"]])  # pyenv's shims last
    found = (shutil.which(name, path=path) for name in SUPPORTED)
    return [python for python in found if python]


def install(python: str, wheel: Path, venv: Path) -> None:
    """Install the wheel with uv in a new environment."""
    run(UV, "venv", "--quiet", "--python", python, venv)
    run(UV, "pip", "install", "--quiet", "--python", venv / "bin" / "python", wheel)


def install_tool(tool: str, source: Path, place: Path) -> Path:
    """Install the command alone, from a wheel or a clone; return the folder of the command."""
    places = ("UV_TOOL_DIR", "UV_TOOL_BIN_DIR", "PIPX_HOME", "PIPX_BIN_DIR")
    settings = {name: str(place / name) for name in places}
    program = [UV, "tool"] if tool == "uv" else [PIPX]
    run(*program, "install", "--quiet", "--python", pythons()[0], source, env=os.environ | settings)
    return place / ("UV_TOOL_BIN_DIR" if tool == "uv" else "PIPX_BIN_DIR")


def use(programs: Path, folder: Path) -> None:
    """Do the first steps of a user, in a folder outside the repository."""
    folder.mkdir()
    unused = folder / "cache"
    environment = {**os.environ, "CHAIN_IMPACT_CACHE": str(unused), "MPLBACKEND": "Agg"}
    if (programs / "python").exists():  # a tool has none there
        run(programs / "python", "-c", CHECK, cwd=folder, env=environment)
    command: list[str | Path] = [programs / "chain-impact", "build", "--simulate"]
    run(*command, cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    made = {file.name for file in (folder / "build").iterdir()}
    assert made >= {"FourLinkBox.fmu", "FourLinkBox.csv", "FourLinkBox.png"}, made
    assert not unused.exists(), "a kernel was compiled, though the wheel should have all"


def main(scratch: Path) -> None:
    """Build the wheel and try it."""
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", scratch / "dist", ".")
    (wheel,) = (scratch / "dist").glob("chain_impact-*.whl")
    # Each environment is deleted here, while other checks run: .ci/run would delete all of them at its end.
    for python in pythons():
        place = scratch / Path(python).name
        install(python, wheel, place)
        use(place / "bin", scratch / f"{place.name}-folder")
        shutil.rmtree(place)
        print(f"{wheel.name}: works with {Path(python).name}, installed by uv")
    for tool, source in [("uv", Path.cwd()), ("pipx", wheel)]:
        place = scratch / f"{tool}-tool-{source.name}"
        use(install_tool(tool, source, place), scratch / f"{place.name}-folder")
        shutil.rmtree(place)
        print(f"{source.name}: works as a tool, installed by {tool}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
