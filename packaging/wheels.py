"""Build all files of a release on one machine: ``python packaging/wheels.py -o dist``.

A wheel for each platform, with its prebuilt kernels, also those with derivatives, and the source
distribution. The same sources and versions of the compilers give the same bytes. Kernels that are in the
cache are not compiled again. Needs the extra ``dev``.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
import zipfile
from pathlib import Path

from kernel_hook import PLATFORM, kernels, platforms, tag

ROOT = Path(__file__).parents[1]
LARGEST = 8e6  # bytes, upper limit of a file: a download of seconds
DATE = "1577836800"  # date of all files in the archives, s since 1970: 2020-01-01


class ReleaseError(Exception):
    """An error with one sentence: a file must not be uploaded."""


def built(target: str, folder: Path, platform: str = "") -> Path:
    """Build a wheel or the source distribution into ``folder``; return its path.

    Raises:
        ReleaseError: when that fails, or does not add exactly one file to the folder.
    """
    settings = {PLATFORM: platform, kernels().prebuilt.RELEASE: "1", "SOURCE_DATE_EPOCH": DATE}
    before = set(folder.iterdir())
    command = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(folder)]
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | settings, stdout=subprocess.DEVNULL, check=False
    )
    made = set(folder.iterdir()) - before
    if done.returncode != 0 or len(made) != 1:
        raise ReleaseError(f"{target} {platform}: hatchling could not build it into {folder}")
    return made.pop()


def check_wheel(wheel: Path, platform: str) -> None:
    """Check that a wheel has the right tag, and kernels of its own platform only, also with derivatives.

    Raises:
        ReleaseError: when it has not.
    """
    wanted = tag(platform)
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (about,) = (name for name in names if name.endswith(".dist-info/WHEEL"))
        tags = [line for line in archive.read(about).decode().splitlines() if line.startswith("Tag: ")]
    endings = tuple(f"-{one}" for one in platforms())
    libraries = [name for name in names if Path(name).stem.endswith(endings)]
    if tags != [f"Tag: {wanted}"] or not wheel.stem.endswith(f"-{wanted}"):
        raise ReleaseError(f"{wheel.name}: its tag is {', '.join(tags)}, and must be {wanted}")
    if not libraries or not all(Path(name).stem.endswith(f"-{platform}") for name in libraries):
        raise ReleaseError(f"{wheel.name}: must have kernels for {platform} only")
    if not any("derivatives-" in name for name in libraries):
        raise ReleaseError(f"{wheel.name}: must have kernels with derivatives")


def check_all(files: list[Path]) -> None:
    """Check the sizes of files, and the display of their metadata on PyPI.

    Raises:
        ReleaseError: when a file is too large, or its metadata cannot be displayed.
    """
    large = [file.name for file in files if file.stat().st_size >= LARGEST]
    if large:
        raise ReleaseError(f"{', '.join(large)}: must be smaller than {LARGEST / 1e6:.0f} MB")
    command = [sys.executable, "-m", "twine", "check", "--strict", *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ReleaseError(f"twine: {done.stdout}{done.stderr}")


def main() -> None:
    """Build and check all files, and print their sizes and SHA-256 sums; the first error ends the program."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", dest="folder", type=Path, default=Path("dist"), help="default: dist")
    known = list(platforms())
    parser.add_argument("--platform", action="append", choices=known, help="only this one; repeatable")
    options = parser.parse_args()
    folder = options.folder.absolute()
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        sys.exit(f"{folder} must be empty")
    try:
        files = []
        for platform in options.platform or known:
            files.append(built("wheel", folder, platform))
            check_wheel(files[-1], platform)
        files.append(built("sdist", folder))
        check_all(files)
    except ReleaseError as error:
        sys.exit(str(error))
    for file in files:
        digest = hashlib.sha256(file.read_bytes()).hexdigest()
        print(f"{digest}  {file.stat().st_size / 1e6:4.1f} MB  {file.name}")


if __name__ == "__main__":
    main()
