"""Convert a file: URDF or MJCF to a scene, a scene to MJCF."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import tomlkit

from chain_impact.conversion.mjcf import read_mjcf
from chain_impact.conversion.planar import Converted, planar_chain
from chain_impact.conversion.to_mjcf import mjcf_of
from chain_impact.conversion.urdf import read_urdf
from chain_impact.scene.models import model_names
from chain_impact.scene.reading import SceneError, SceneWarning
from chain_impact.scene.scene import Scene, scene_from_dict, scene_of, scene_to_dict
from chain_impact.system import written_whole

READERS = {"robot": read_urdf, "mujoco": read_mjcf}
"""Root element of a file → what reads it."""


def of_robot(path: Path, joints: Sequence[str] = ()) -> tuple[Scene, Converted]:
    """The scene of a robot in URDF or MJCF, and the conversion that it comes from.

    Args:
        path: the file.
        joints: names of those that move, all others are held at their start; none: all move.

    Raises:
        SceneError: when the file has no planar chain.
        MissingExtraError: when the package that reads the format is not installed.
        OSError: when the file cannot be read.
    """
    if path.name in model_names() or path.suffix == ".toml":
        raise SceneError(f"{path} is a scene; its MJCF is written to a file that ends in .xml")
    try:
        root = ElementTree.parse(path).getroot().tag
    except ElementTree.ParseError as error:
        raise SceneError(f"{path}: is no XML: {error}") from None
    if root not in READERS:
        raise SceneError(f"{path}: its root element is {root!r}, must be 'robot' (URDF) or 'mujoco' (MJCF)")
    done = planar_chain(READERS[root](path), joints, str(path))
    done.data["name"] = _identifier(done.data["name"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # numbers of a file are in the units that it says
        return scene_from_dict(done.data, str(path)), done


def _identifier(name: str) -> str:
    """A name of letters, digits and _ that does not begin with a digit."""
    plain = re.sub(r"\W+", "_", name, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z_]", plain) else f"model_{plain}"


def convert(source: str | Path, output: Path, joints: Sequence[str] = ()) -> Converted:
    """Write the scene of a robot (.toml), or the MJCF of a scene (.xml).

    A scene has what is to be said as comments at its beginning. Raises as ``of_robot`` and ``load_scene`` do.
    """
    if output.suffix.lower() == ".xml":
        scene = scene_of(source)
        text, left_out = mjcf_of(scene)
        done = Converted(scene_to_dict(scene), [], left_out)
    else:
        _, done = of_robot(Path(source), joints)
        lines = [f"From {Path(source).name}.", *done.notes, *(f"left out: {one}" for one in done.left_out)]
        text = "".join(f"# {line}\n" for line in lines) + f"\n{tomlkit.dumps(done.data)}"
    with written_whole(output) as fresh:
        fresh.write_text(text, encoding="utf-8")
    return done
