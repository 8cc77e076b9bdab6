"""Draw all images of the docs, with Chromium: ``python -m docs.tools.images``.

With words after the command, only programs, models and pages whose names have one of these words are drawn.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from chain_impact.pictures.drawing.colours import TIME_COLOURS
from chain_impact.scene.files.models import model_names
from docs.tools import DOCS

IMAGES = DOCS / "images"
CLI = "-m chain_impact.cli"
PROGRAMS = (
    f"{CLI} animate four_link_box --set simulation.stop_time=1.25 --impact-time 0.4 "
    "--size 800x450 -o docs/images/four_link_box.gif",
    f"{CLI} compare four_link_box --plot docs/images/compare.png",
    f"{CLI} simulate four_link_box --stop-time 1.1 --sensitivity "
    'contact.restitution,contact.stiffness --sensitivity "link[2].mass" --plot docs/images/sensitivities.png',
    f"{CLI} simulate pinned_arm --rank peak_force "
    '--sensitivity "contact.*,link[*].mass,joint[*].torque" --plot docs/images/ranking.png',
    f"{CLI} sweep four_link_box --set simulation.stop_time=0.6 "
    "--vary contact.restitution=0.05:0.95:46 --vary contact.stiffness=1e6:1e9:31:log -o build/map.csv "
    "--plot docs/images/sweep.png",
    "models/carried_arm/co_simulation.py --plot docs/images/carried_arm.png",
    "models/controlled_arm/co_simulation.py --plot docs/images/controlled_arm.png",
    "models/cart_pole/co_simulation.py --plot docs/images/cart_pole_balanced.png",
    "-m docs.tools.screenshot",
    "-m tests.helpers.literature.beside_measurements",
    "-m docs.tools.sensitivity_chart",
    "-m docs.tools.paper_chart",
    "-m docs.tools.charts",
    "-m benchmarks tables --charts",
)
"""The arguments with which Python draws images."""
MODELS_OF_PROGRAMS = {"carried_arm", "controlled_arm", "golf_ball", "steel_bar", "triple_pendulum"}
"""The models without an image of their simulated motion; a program of PROGRAMS draws their images."""
OF_PAGES = {
    "fit.md": {"fit.png": "fit.png"},
    "mount.md": {"joints.png": "joint_force.png"},
    "robot_load.md": {"load.png": "robot_load.png"},
    "models/triple_pendulum.md": {"pendulum.png": "fit_pendulum.png"},
}
"""Page → picture that its commands draw → name of the image."""
BLOCK = re.compile(r'^```(\w+)(?: title="([^"]*)")?\n(.*?)^```$', re.M | re.S)
COLOURS = 256  # the number of colours of an image, which keeps its file small
TIMES = 96  # the number of these colours for times, if an image shows times by colours
LEAST_TIMES = 48  # an image with at least so many of the TIMES colours shows times by colours


def main(parts: list[str]) -> None:
    """Run all programs, one after the other; then draw the models and the pictures of pages."""
    (DOCS.parent / "build").mkdir(exist_ok=True)
    models = [
        f"{CLI} simulate {name} --plot docs/images/{name}.png"
        for name in model_names()
        if name not in MODELS_OF_PROGRAMS
    ]
    times = {image: image.stat().st_mtime for image in IMAGES.glob("*.png")}
    for program in chosen([*models, *PROGRAMS], parts):
        print(program, flush=True)
        run(*shlex.split(program))
    for page in chosen(OF_PAGES, parts):
        print(page, flush=True)
        draw_page(page)
    for image in IMAGES.glob("*.png"):
        if image.stat().st_mtime != times.get(image):
            shrink(image)


def chosen(names: list[str] | dict[str, dict[str, str]], parts: list[str]) -> list[str]:
    """Return the names that contain one of the texts ``parts``; all names if ``parts`` is empty."""
    return [name for name in names if not parts or any(part in name for part in parts)]


def run(*arguments: str, folder: Path = DOCS.parent) -> None:
    """Run Python in a folder."""
    subprocess.run([sys.executable, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def draw_page(page: str) -> None:
    """Run the files, programs and commands of a page in a new folder, and copy the pictures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "models").symlink_to(DOCS.parent / "models")
        for language, title, text in BLOCK.findall((DOCS / page).read_text(encoding="utf-8")):
            if title and title != "printed":
                (folder / title).write_text(text, encoding="utf-8")
            elif language == "python":
                run("-c", text, folder=folder)
            elif language == "sh":
                for line in text.splitlines():
                    if line.startswith("chain-impact "):
                        run(*CLI.split(), *shlex.split(line, comments=True)[1:], folder=folder)
        for picture, image in OF_PAGES[page].items():
            shutil.copyfile(folder / picture, IMAGES / image)


def shrink(image: Path) -> None:
    """Write an image file again with COLOURS colours; the texts in the file stay.

    If the image shows times by colours, TIMES of its colours are fixed: a bar of times has no visible steps.
    """
    with Image.open(image) as picture:
        words = PngInfo()
        for key, text in getattr(picture, "text", {}).items():
            words.add_itxt(key, text)
        whole_picture = picture.convert("RGB")
    reduced = whole_picture.quantize(COLOURS, dither=Image.Dither.NONE)
    shades = (255.0 * TIME_COLOURS(np.linspace(0.0, 1.0, TIMES))[:, :3]).round().astype(int)
    used_colours = np.unique(np.asarray(whole_picture).reshape(-1, 3), axis=0).astype(int)
    is_shade = [(np.abs(used_colours - shade).max(axis=1) <= 1).any() for shade in shades]
    if np.count_nonzero(is_shade) >= LEAST_TIMES:
        other_colours = whole_picture.quantize(COLOURS - TIMES, dither=Image.Dither.NONE).getpalette() or []
        palette = Image.new("P", (1, 1))
        palette.putpalette([*shades.ravel().tolist(), *other_colours[: 3 * (COLOURS - TIMES)]])
        reduced = whole_picture.quantize(palette=palette, dither=Image.Dither.NONE)
    reduced.save(image, optimize=True, pnginfo=words)


if __name__ == "__main__":
    main(sys.argv[1:])
