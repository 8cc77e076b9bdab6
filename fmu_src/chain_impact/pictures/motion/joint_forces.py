"""The largest force in each joint, in the picture of a motion.

Each force is an arrow at the position that the joint had at the time of the force. The values of the
MOST_FORCES largest forces stand beside their joints, as far as there is room.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.colours import LOAD
from chain_impact.pictures.drawing.labels import Label, place_labels
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.motion.view import View, view_of
from chain_impact.recording.joint_peaks import joint_peaks
from chain_impact.recording.recording import Recording

# the length of the arrow for the largest force in a joint, relative to the smaller side of the view
LONGEST_LOAD = 0.3
# if an arrow would leave the view, all arrows become shorter; but the arrow for the largest force keeps at
# least the part SHORTEST_LOAD of LONGEST_LOAD, so an arrow near the edge may still leave the view
SHORTEST_LOAD = 0.4
# POSE_WIDTH: [points] the width of the chain in the pose of the arrows; POSE_LAYER: matplotlib's order of
# drawing (zorder) for this chain, above all other poses
POSE_WIDTH, POSE_LAYER = 1.6, 4.5
# LOAD_SHIFT: how far an arrow stands beside a link that it would cover, relative to the longer side of the
# view; LINK_TANGENT: the largest tangent of the angle between a link and an arrow that would cover the link
LOAD_SHIFT, LINK_TANGENT = 0.025, 0.3
# two poses look alike if no point differs by more than this, relative to the longer side of the view
SAME_POSE = 0.03
MOST_FORCES = 3  # the largest number of joints whose forces are written


def draw_loads(axes: Axes, recording: Recording, view: View, shown_poses: Sequence[np.ndarray] = ()) -> None:
    """Draw the largest force in each joint as an arrow at the place of the joint at the time of this force.

    Direction and position of an arrow are those in the row nearest to the time of the largest force in the
    joint; the length shows the largest force, which may lie between rows. An arrow along a link stands beside
    this link (``shifted_foot``). The pose of the chain at the time of the largest of all these forces has the
    colour of the arrows, unless it is like one of ``shown_poses`` (SAME_POSE). If an arrow would leave the
    view, all arrows become shorter, as far as SHORTEST_LOAD allows. A recording without loads has no arrows.
    """
    arrows, loads, side = [], joint_peaks(recording), float(np.ptp(view.corners, axis=0).max())
    for peak in loads:
        if peak.joint in recording.joint_forces:
            row = recording.row_at(peak.time)
            force = recording.joint_forces[peak.joint][row]
            if size := np.hypot(*force):
                foot = shifted_foot(recording.points[row], peak.joint, force, LOAD_SHIFT * side)
                arrows.append((*foot, *(peak.force / size * force)))
    if arrows:
        # ``POSE_LAYER`` is above the layer of the pose at the end, which could cover the pose drawn here
        pose = recording.pose_at(loads[0].time)
        if all(np.hypot(*(pose - shown_pose).T).max() > SAME_POSE * side for shown_pose in shown_poses):
            axes.plot(*pose.T, ".-", color=LOAD, linewidth=POSE_WIDTH, zorder=POSE_LAYER)
        x, y, x_forces, y_forces = np.transpose(arrows)
        largest_force = np.hypot(x_forces, y_forces).max()
        longest_arrow = LONGEST_LOAD * min(np.ptp(view_of(recording).corners, axis=0))
        ways = longest_arrow / largest_force * np.stack([x_forces, y_forces], axis=-1)
        longest_arrow *= max(SHORTEST_LOAD, part_in_view(np.stack([x, y], axis=-1), ways, view.corners))
        axes.quiver(
            *(x, y, x_forces, y_forces),
            angles="xy",
            scale_units="xy",
            scale=largest_force / longest_arrow,
            color=LOAD,
            zorder=6,
            clip_on=False,
            in_layout=False,
        )
        key_style: dict[str, Any] = {"marker": "$\u2192$", "markersize": 8.0, "linestyle": "", "color": LOAD}
        axes.plot([], [], **key_style, label=f"joint forces\n≤ {force_text(largest_force, 'N')}")


def shifted_foot(pose: np.ndarray, joint: int, force: np.ndarray, shift: float) -> np.ndarray:
    """Return the foot of the arrow of a force in a joint [m]: the joint, or a place beside it.

    If the force is nearly along a link at the joint (LINK_TANGENT), the arrow would cover this link. The foot
    is then farther from the link by ``shift`` [m], on the side to which the arrow turns away from it.
    """
    foot = pose[joint - 1]
    for neighbour in (joint, joint - 2):
        if 0 <= neighbour < len(pose):
            link, (fx, fy) = pose[neighbour] - foot, force / np.hypot(*force)
            dot_product, cross_product = fx * link[0] + fy * link[1], fx * link[1] - fy * link[0]
            if dot_product > 0.0 and abs(cross_product) < LINK_TANGENT * dot_product:
                return np.asarray(
                    foot + shift * np.array([fy, -fx]) * (1.0 if cross_product >= 0.0 else -1.0)
                )
    return np.asarray(foot)


def part_in_view(positions: np.ndarray, ways: np.ndarray, corners: np.ndarray) -> float:
    """Return the largest factor, at most 1, on the lengths of arrows with which all arrows end in a view.

    ``positions`` has the feet of the arrows, ``ways`` the vectors from the feet to the heads, both of shape
    (A, 2) [m]; ``corners`` are the lower left and the upper right corner of the view, shape (2, 2) [m].
    """
    room = np.where(ways > 0.0, corners[1], corners[0]) - positions
    parts = np.divide(room, ways, out=np.ones_like(ways), where=ways != 0.0)
    return float(parts.min(initial=1.0))


def name_loads(axes: Axes, recording: Recording, used_pixels: UsedPixels, wanted_joints: slice) -> bool:
    """Write those of the MOST_FORCES largest joint forces that are ``wanted_joints``, where pixels are free.

    ``wanted_joints`` selects from the forces, the largest first. Each force stands near the position of its
    joint at the time of the force. A force without room leaves out all smaller ones. Returns whether all have
    room.
    """
    peaks = [peak for peak in joint_peaks(recording)[:MOST_FORCES][wanted_joints] if peak.force > 0.0]
    values = [force_text(peak.force, "N") for peak in peaks]
    labels = [
        Label(
            f"joint {peak.joint}: {value}",
            tuple(recording.pose_at(peak.time)[peak.joint - 1].tolist()),
            short=value,
        )
        for peak, value in zip(peaks, values, strict=True)
    ]
    look: dict[str, Any] = {"lines": True, "fontsize": "small", "color": LOAD}
    return all(not place_labels(axes, [label], used_pixels, **look) for label in labels)
