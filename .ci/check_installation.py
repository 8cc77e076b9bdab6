"""Check the package that the README's first command installs.

The script runs in the folder of this command, with the Python of the environment that the command makes.

``CHAIN_IMPACT_CACHE`` (compilation/folders.py) must name a folder that does not exist.

The checks: no compiler, kernels for every chain and every kind of FMU, the right tag, and a small size.
"""

import sys
import tempfile
from importlib.metadata import distribution
from importlib.util import find_spec
from pathlib import Path

import fmpy

import chain_impact
from chain_impact import BuildError, build_fmu, explore, fit, load_scene, simulate
from chain_impact.compilation import folders, prebuilt
from chain_impact.scene.scene import scene_from_dict, with_values

MOST = 470  # MB
# the kernel and the kernel with derivatives, each with static and with moving walls, and a browser module
LIBRARIES = 5
CLOSE = 1e-3  # allowed difference of the fitted restitution from the data's restitution
TAG = "Tag: py3-none-manylinux_2_17_x86_64"


def chain(links: int) -> dict[str, object]:
    """Return a scene in which a chain falls on the floor."""
    return {
        "name": "Chain",
        "chain": {"links": [{"length": 0.2, "mass": 0.3}] * links},
        "box": {"y_min": 0.0},
        "initial": {"position": [0.1, 0.5], "angles": [0.01 * i for i in range(links)]},
    }


installed = [name for name in ("numba", "llvmlite", "ziglang") if find_spec(name)]
assert not installed, f"compilers are installed for ordinary use: {installed}"
assert Path("build/FourLinkBox.png").is_file()
wheel = distribution("chain-impact").read_text("WHEEL") or ""
assert TAG in wheel, wheel

assert len(prebuilt.prebuilt_kernels()) == LIBRARIES
for links in (1, 4, prebuilt.LARGEST_EXACT, prebuilt.LARGEST_EXACT + 1, 64):
    assert len(simulate(scene_from_dict(chain(links), "chain"), stop_time=0.35).impacts) > 0
scratch = tempfile.TemporaryDirectory()
assert build_fmu("rod_drop", scratch.name, target="native").is_file()
rod = load_scene("rod_drop")
varied = rod.with_values({"outputs.sensitivities": ["contact.stiffness"]})
for target in ("pythonfmu", "native"):
    fmu = build_fmu(varied, Path(scratch.name, target), target=target)
    slope = "sensitivity.contact.stiffness.point[1].y"
    assert fmpy.simulate_fmu(str(fmu), stop_time=rod.simulation.stop_time, output=[slope])[slope].any()
measured = simulate(rod, stop_time=0.6, output_step=0.01)
columns = {"time": measured.time, "point[1].y": measured["point[1].y"]}
found = fit(rod.with_values({"contact.restitution": 0.6}), columns, ["contact.restitution"])
assert abs(found.values["contact.restitution"] - rod.contact.restitution) < CLOSE
explore(rod, Path(scratch.name, "page.html"))
assert not folders.base_folder().exists(), "a kernel was looked for in the cache, though all should be ready"

law = Path(scratch.name, "mine.py")
law.write_text("def mine(penetration):\n    return 1e6 * penetration\n", encoding="utf-8")
own = with_values(load_scene("rod_drop"), {("contact", "law_file"): str(law), ("contact", "model"): "mine"})
try:
    simulate(own)
    said = "nothing"
except BuildError as error:
    said = str(error)
how = f"{sys.executable} -m pip install "
_, is_told, packages_to_install = said.partition(how)
assert is_told, f"without a compiler a law of your own said {said}, and not {how}"
assert all(f"{name}==" in packages_to_install for name in ("numba", "llvmlite", "ziglang")), said

packages = Path(chain_impact.__file__).parents[1]
of_the_environment = ("pip", "setuptools", "pkg_resources", "_distutils_hack")
files = [
    file.lstat()
    for file in packages.rglob("*")
    if file.is_file() and not file.is_symlink()
    if not file.relative_to(packages).parts[0].startswith(of_the_environment)
]
size = sum(file.st_blocks * 512 for file in files) / 1e6
print(f"installed: {size:.0f} MB, no compiler")
assert size <= MOST
