"""The conversion of a file: of a robot in URDF or MJCF to a scene, or of a scene to MJCF."""

from __future__ import annotations

import warnings
from functools import cache
from pathlib import Path

import tomlkit

from chain_impact.conversion.differences import DIFFERS, LEFT_OUT, WARNING
from chain_impact.conversion.embedded_scene import EmbeddedScene, merge_embedded_scene, read_embedded_scene
from chain_impact.conversion.mjcf import read_mjcf
from chain_impact.conversion.mjcf_writing import mjcf_of
from chain_impact.conversion.planar import ConversionChoices, ConversionResult
from chain_impact.conversion.proposals import chain_of
from chain_impact.conversion.robot import Robot, identifier
from chain_impact.conversion.urdf import local_name, read_urdf, xml_of
from chain_impact.files import written_atomically
from chain_impact.scene.errors import SceneError, SceneWarning
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import Scene, scene_from_dict, scene_of, scene_to_dict

ALL_CHOICES = ConversionChoices()


def scene_of_robot(path: Path, choices: ConversionChoices = ALL_CHOICES) -> tuple[Scene, ConversionResult]:
    """Return the scene of a robot in URDF or MJCF, and its conversion with data and remarks.

    ``choices`` are the user's choices for the conversion.

    Raises:
        SceneError: when the file is not URDF or MJCF, has no planar chain, or the choices do not fit it.
        MissingExtraError: when the package that reads the format is not installed.
        OSError: when the file cannot be read.
    """
    with warnings.catch_warnings():
        # numbers of which the checks of a scene warn, because they are probably mistakes, are usual for
        # robots
        warnings.simplefilter("ignore", SceneWarning)
        robot = read_robot(path, choices.keyframe)

        @cache
        def read_embedded() -> EmbeddedScene | None:
            data = robot.embedded_data
            return None if data is None else read_embedded_scene(data, robot.name, str(path))

        def with_embedded(chain_result: ConversionResult) -> ConversionResult:
            embedded_scene = read_embedded()
            return (
                chain_result
                if embedded_scene is None
                else merge_embedded_scene(chain_result, embedded_scene, choices)
            )

        result = with_embedded(
            chain_of(
                robot,
                choices,
                str(path),
                lambda chain_result: _converted_scene(with_embedded(chain_result), path),
            )
        )
        return _converted_scene(result, path), result


def read_robot(path: Path, keyframe: str | None = None) -> Robot:
    """Return the robot of a file in URDF or MJCF; ``keyframe`` is that of ``ConversionChoices``.

    The errors are those of ``scene_of_robot``.
    """
    if path.name in model_names() or path.suffix == ".toml":
        raise SceneError(f"{path} is a scene; its MJCF is written to a file that ends in .xml")
    root = local_name(xml_of(path).tag)
    if root == "mujoco":
        return read_mjcf(path, keyframe)
    if root != "robot":
        raise SceneError(f"{path}: its root element is {root!r}, must be 'robot' (URDF) or 'mujoco' (MJCF)")
    if keyframe is not None:
        raise SceneError(": URDF has no keyframes", source=str(path), argument="keyframe", value=keyframe)
    return read_urdf(path)


def _converted_scene(result: ConversionResult, path: Path) -> Scene:
    result.data["name"] = identifier(result.data["name"], "model")
    return scene_from_dict(result.data, str(path))


def convert(source: str | Path, output: Path, choices: ConversionChoices = ALL_CHOICES) -> ConversionResult:
    """Write the scene ``source`` as MJCF if ``output`` ends in .xml, else the robot ``source`` as a scene.

    Return the conversion with its remarks; in a written scene, these are also comments at the beginning. The
    errors are those of ``scene_of_robot`` and ``load_scene``.
    """
    if output.suffix.lower() == ".xml":
        scene = scene_of(source)
        text, differing_texts, left_out = mjcf_of(scene)
        result = ConversionResult(scene_to_dict(scene), [], differing_texts, left_out, [])
    else:
        _, result = scene_of_robot(Path(source), choices)
        remarks = [
            f"From {Path(source).name}.",
            *(f"{title}: {line}" for title, line in remark_lines(result)),
        ]
        text = "".join(f"# {line}\n" for line in remarks) + f"\n{tomlkit.dumps(result.data)}"
    with written_atomically(output) as new_file:
        new_file.write_text(text, encoding="utf-8")
    return result


def remark_lines(result: ConversionResult) -> list[tuple[str, str]]:
    """Return the remarks of a conversion as pairs (title, sentence), warnings first and notes last."""
    titles = (WARNING, DIFFERS, LEFT_OUT, "note")
    remarks = (result.warnings, result.differs, result.left_out, result.notes)
    return [(title, line) for title, lines in zip(titles, remarks, strict=True) for line in lines]
