"""The plane in space in which a chain moves, and the directions of the scene's axes in this plane."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.joints import PARALLEL_ANGLE
from chain_impact.scene.errors import SceneError

ZERO_LENGTH = 1e-9  # [m] a length up to ZERO_LENGTH counts as 0, because it may be round-off
# a number of smaller magnitude counts as 0; the round-off of numbers near 1 is smaller
NUMBER_ROUND_OFF = 1e-14
# number of significant digits of each real number in the scene of a robot; robot files usually have fewer
# digits, so most further digits are round-off
SCENE_DIGITS = 14
X, Y, Z = np.eye(3)


class MotionPlane(NamedTuple):
    """The plane in which a chain moves, by the directions of the scene's axes.

    Attributes:
        x: unit vector, in the robot's axes, along the scene's x axis.
        y: unit vector, in the robot's axes, along the scene's y axis.
        axis: unit vector, in the robot's axes, about which the scene's angles are positive: x × y.
    """

    x: np.ndarray
    y: np.ndarray
    axis: np.ndarray

    def project(self, point: np.ndarray) -> np.ndarray:
        """Return the coordinates in the scene, shape (…, 2), of points or vectors in space, shape (…, 3)."""
        return np.stack([point @ self.x, point @ self.y], axis=-1)

    @property
    def remark(self) -> str:
        """A sentence on the directions of the scene's axes, for the user."""
        axes = [" ".join(f"{part:.4g}" for part in axis) for axis in (self.x, self.y)]
        return f"plane: x of the scene is ({axes[0]}) of the robot, y is ({axes[1]})"


def motion_plane_of(axis: np.ndarray, directions: str | None, source: str) -> MotionPlane:
    """Return the plane at right angles to ``axis``, the direction of the joints' axes, and the scene's axes.

    By default the scene's y axis points along the robot's z axis, upwards, as far as the plane allows, and
    the scene's x axis is horizontal, in the direction nearer to the robot's x axis; if the two are at right
    angles, in the direction nearer to the robot's y axis. If ``axis`` is vertical, the scene has the robot's
    x and y axes. ``directions`` replace this default: with ``-x,z`` the scene's x axis points along −x of the
    robot, and the scene's y axis along z of the robot. ``source`` is the file's name for errors.

    Raises:
        SceneError: when the directions are not two directions at right angles to each other and to ``axis``.
    """
    axis = axis / np.linalg.norm(axis)
    if directions is not None:
        x, y = _chosen_axes(axis, directions, source)
    else:
        up_direction = _component_across(Z, axis)
        y = up_direction if np.linalg.norm(up_direction) > PARALLEL_ANGLE else _component_across(Y, axis)
        y = y / np.linalg.norm(y)
        x = np.cross(y, axis)
        x = x * (_sign(x[0]) or _sign(x[1]))
    x, y = _without_round_off(x), _without_round_off(y)
    return MotionPlane(x, y, np.cross(x, y))


def _component_across(direction: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return the component of a vector that is at right angles to the unit vector ``axis``."""
    return np.asarray(direction - np.dot(direction, axis) * axis)


def _sign(value: float) -> float:
    return 0.0 if abs(value) < PARALLEL_ANGLE else float(np.sign(value))


def _chosen_axes(axis: np.ndarray, directions: str, source: str) -> tuple[np.ndarray, np.ndarray]:
    axes = {
        f"{sign}{name}": factor * direction
        for sign, factor in (("", 1.0), ("-", -1.0))
        for name, direction in zip("xyz", (X, Y, Z), strict=True)
    }
    names = [part.strip() for part in directions.split(",")]
    allowed_text = f"must be two of {', '.join(axes)}, for example x,z"
    if len(names) != 2 or any(name not in axes for name in names):  # noqa: PLR2004
        raise SceneError(allowed_text, argument="plane", value=directions)
    x, y = (axes[name] for name in names)
    if abs(np.dot(x, y)) > PARALLEL_ANGLE or max(abs(np.dot(x, axis)), abs(np.dot(y, axis))) > PARALLEL_ANGLE:
        axis_text = " ".join(f"{part:.4g}" for part in _without_round_off(axis))
        raise SceneError(
            ": x and y must be at right angles to each other and to the axes of the joints, which point "
            f"along ({axis_text})",
            source=source,
            argument="plane",
            value=directions,
        )
    return x, y


def rounded_to_zero(value: float) -> float:
    """Return ``value``, or 0 if its magnitude is below NUMBER_ROUND_OFF."""
    return 0.0 if abs(value) < NUMBER_ROUND_OFF else value


def round_numbers(data: Any) -> Any:
    """Return the data of a scene with each real number rounded to SCENE_DIGITS significant digits."""
    if isinstance(data, dict):
        return {key: round_numbers(value) for key, value in data.items()}
    if isinstance(data, list):
        return [round_numbers(value) for value in data]
    return rounded_to_zero(float(f"{data:.{SCENE_DIGITS}g}")) if isinstance(data, float) else data


def _without_round_off(axis: np.ndarray) -> np.ndarray:
    """Return the unit vector ``axis``, with 0 or ±1 for each component that is near it, up to round-off."""
    whole_numbers = np.rint(axis)
    return np.where(np.abs(axis - whole_numbers) < NUMBER_ROUND_OFF, whole_numbers, axis) + 0.0
