"""What a frame of a film shows: the chain between its walls, its energy, the clock and the forces."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch
from matplotlib.patheffects import withStroke

from chain_impact.results.animation.frames import Motion
from chain_impact.results.animation.text import force_text, rate_text
from chain_impact.results.joint_stops import range_lines, touching_place
from chain_impact.results.plots.over_time import ENERGY_COLOURS
from chain_impact.results.plots.room import OUTSIDE_COLOUR, draw_pin, draw_room
from chain_impact.results.plots.style import BLUE, BROWN, INK, PALE

MUTED, CHAIN, TIP, FORCE = "#566076", "#2b4a9f", "#c2255c", "#d9480f"
ENERGIES = {**ENERGY_COLOURS, "elastic": BLUE, "friction": BROWN}
COLOURS = (INK, MUTED, PALE, OUTSIDE_COLOUR, CHAIN, TIP, FORCE, *ENERGIES.values())
"""All colours of a film, but white and their shades."""
STYLE: Any = {
    "font.size": 9,
    "text.color": INK,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": MUTED,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
}
"""Settings of matplotlib for a film."""
SCENE, ENERGY = (0.02, 0.03, 0.6, 0.85), (0.69, 0.12, 0.29, 0.6)  # left, bottom, width, height of the page
CLOCK, RATE = (0.69, 0.94), (0.69, 0.87)  # left, and the middle of the height
ROOM = (8.0, 4.5)  # inches, width and height that a page with energies has at least
SMALL_SCENE, SMALL_CLOCK, SMALL_RATE = (0.02, 0.03, 0.96, 0.75), (0.02, 0.84), (0.55, 0.84)
"""The same of a page that has no room for energies."""
ABOVE: Any = {"loc": "lower left", "bbox_to_anchor": (-0.02, 1.0), "borderaxespad": 0.2}
LONGEST = 0.26  # of the smaller side of the scene: the arrow of the largest force
LEAST = 0.02  # of the same: the shortest arrow
BAR = 0.035  # of the same: half the bar along the wall where a contact sticks
TAIL, TAIL_PARTS = 0.3, 40  # s of simulated time in which the trace of the tip fades, and its pieces


class FilmPage:
    """The page that the frames of a film show."""

    def __init__(self, figure: Figure, motion: Motion) -> None:
        """Draw what does not move."""
        self.motion = motion
        wide = bool((figure.get_size_inches() > 0.99 * np.array(ROOM)).all())
        scene, clock, rate = (SCENE, CLOCK, RATE) if wide else (SMALL_SCENE, SMALL_CLOCK, SMALL_RATE)
        self.tells_energies = wide and bool(motion.energies)
        self.scene = figure.add_axes(scene)
        self.energy = figure.add_axes(ENERGY, visible=self.tells_energies)
        figure.text(SCENE[0], 0.94, motion.name, fontsize=13 if wide else 10, fontweight="bold", va="center")
        moving: dict[str, Any] = {"animated": True, "va": "center"}
        self.clock = figure.text(*clock, "", fontsize=15 if wide else 10, fontweight="bold", **moving)
        self.rate = figure.text(*rate, "", fontsize=10, **moving)
        self._draw_ground()
        self._draw_energies()
        still: dict[str, Any] = {"animated": True, "solid_capstyle": "round", "solid_joinstyle": "round"}
        (self.trace,) = self.scene.plot([], [], color=TIP, linewidth=0.8, alpha=0.35, **still)
        self.tail = LineCollection([], colors=TIP, animated=True)
        self.scene.add_collection(self.tail, autolim=False)
        self.ranges = LineCollection([], colors=MUTED, linewidths=1.2, animated=True)
        self.scene.add_collection(self.ranges, autolim=False)
        disc: dict[str, Any] = {"facecolor": (*to_rgb(CHAIN), 0.14), "edgecolor": CHAIN, "animated": True}
        touching = motion.touching if motion.radius > 0.0 else []
        self.discs = {point: Circle((0, 0), motion.radius, **disc) for point in touching}
        for patch in self.discs.values():
            self.scene.add_patch(patch)
        (self.chain,) = self.scene.plot([], [], color=CHAIN, linewidth=4.0, **still)
        look: dict[str, Any] = {"linestyle": "", "marker": "o", "animated": True}
        (self.joints,) = self.scene.plot([], [], color="white", markeredgecolor=CHAIN, markersize=5, **look)
        (self.tip,) = self.scene.plot([], [], color=TIP, markeredgecolor="white", markersize=7, **look)
        self.now = self.energy.axvline(motion.time[0], color=INK, linewidth=1.0, animated=True)
        peaks = [c.peak_force for c in motion.contacts if c.peak_force is not None and c.arm is None]
        self.peak = max(peaks, default=1.0)

    def _draw_ground(self) -> None:
        axes, view = self.scene, self.motion.view
        # the same scale along x and y: the view, and beside or above it as much as the page has room for
        room = axes.get_window_extent().size
        size = np.ptp(view, axis=0)
        seen = room * (size / room).max()
        low = view[0] - self.motion.anchor * (seen - size)
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        draw_room(axes, low + np.array([np.zeros(2), seen]), list(self.motion.walls.values()))
        draw_pin(axes, self.motion.pin)

    def _draw_energies(self) -> None:
        axes, motion = self.energy, self.motion
        for contact in motion.contacts:
            axes.axvline(contact.onset, color=PALE, linewidth=0.8, zorder=0)
        for name, energy in motion.energies.items():
            look: dict[str, Any] = {
                "color": ENERGIES[name],
                "label": name,
                "linewidth": 1 + (name == "total"),
            }
            axes.plot(motion.time, energy, "--" if name == "friction" else "-", **look)
        axes.set(xlim=(motion.time[0], motion.time[-1]), xlabel="time [s]", ylabel="energy [J]")
        if self.tells_energies:
            axes.legend(**ABOVE, ncols=3, fontsize=8, handlelength=1.0, columnspacing=1.0)

    def show(self, frame: int, rate: float) -> Iterable[Artist]:
        """Move to a frame; give what is to be drawn, in order.

        Args:
            frame: 0…F − 1.
            rate: simulated seconds in a second on the screen.
        """
        motion = self.motion
        time, points = motion.time[frame], motion.points[frame]
        self.trace.set_data(*motion.points[: frame + 1, -1].T)
        self._show_tail(frame)
        for point, disc in self.discs.items():
            disc.set_center(tuple(points[point]))
        self.chain.set_data(*points.T)
        self.joints.set_data(*points[:-1].T)
        self.tip.set_data(*points[-1:].T)
        self.now.set_xdata([time, time])
        self.clock.set_text(f"{time:.5f} s")
        self.rate.set_text(rate_text(rate))
        self.rate.set_color(FORCE if rate < 0.5 else MUTED)  # noqa: PLR2004
        self.ranges.set_segments(list(range_lines(points, motion.stops)))
        yield from (self.trace, self.tail, *self.discs.values(), self.ranges)
        yield from (self.chain, self.joints, self.tip)
        yield from self._arrows(frame)
        yield from self._stop_marks(frame)
        yield from self._stuck_joints(frame)
        yield from (self.clock, self.rate)
        if self.tells_energies:
            yield self.now

    def _show_tail(self, frame: int) -> None:
        motion = self.motion
        time = motion.time[frame]
        moments = np.linspace(max(time - TAIL, motion.time[0]), time, TAIL_PARTS + 1)
        tip = np.stack(
            [np.interp(moments, motion.time, motion.points[:, -1, axis]) for axis in (0, 1)], axis=-1
        )
        self.tail.set_segments(list(np.stack([tip[:-1], tip[1:]], axis=1)))
        self.tail.set_alpha(list(np.linspace(0.0, 1.0, TAIL_PARTS)))
        self.tail.set_linewidth(list(np.linspace(0.5, 2.2, TAIL_PARTS)))

    def _arrows(self, frame: int) -> Iterable[Artist]:
        """The forces of walls on the chain, their lengths in proportion, and how large they are.

        With dry friction an arrow leans, and a bar along the wall shows that the contact sticks.
        """
        side = min(np.ptp(self.motion.view, axis=0))
        for (point, name), force in self.motion.forces.items():
            if force[frame] <= 0.0:
                continue
            wall = self.motion.walls[name]
            normal, place = np.array(wall.normal), self.motion.points[frame, point]
            foot = place - wall.clearance(*place) * normal
            tangent = np.array([normal[1], -normal[0]])
            along = self.motion.friction.get((point, name), np.zeros(frame + 1))[frame]
            whole = np.hypot(force[frame], along)
            direction = (force[frame] * normal + along * tangent) / whole
            head = foot + side * max(LEAST, LONGEST * whole / self.peak) * direction
            if self._sticks(frame, point, name):
                bar = np.stack([foot - BAR * side * tangent, foot + BAR * side * tangent])
                (line,) = self.scene.plot(*bar.T, color=FORCE, linewidth=5.0, solid_capstyle="butt")
                yield line
                line.remove()
            style: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 11, "shrinkA": 0, "shrinkB": 0}
            arrow = FancyArrowPatch(tuple(foot), tuple(head), color=FORCE, linewidth=2.2, **style)
            yield self.scene.add_patch(arrow)
            yield from self._told(force_text(whole), head + 0.035 * side * direction)
            arrow.remove()

    def _sticks(self, frame: int, number: int, wall: str = "") -> bool:
        """Whether a contact, or without a wall a joint, sticks in a frame."""
        sticking = self.motion.sticking.get((number, wall))
        return sticking is not None and bool(sticking[frame])

    def _stuck_joints(self, frame: int) -> Iterable[Artist]:
        """A full dot on each joint that sticks."""
        joints = [joint for joint, wall in self.motion.sticking if not wall and self._sticks(frame, joint)]
        if joints:
            places = self.motion.points[frame][np.array(joints) - 1]
            (dots,) = self.scene.plot(*places.T, "o", color=FORCE, markeredgecolor=CHAIN, markersize=7)
            yield dots
            dots.remove()

    def _stop_marks(self, frame: int) -> Iterable[Artist]:
        """A dot where a joint is at its stop, and how large the moment is."""
        side = min(np.ptp(self.motion.view, axis=0))
        for (joint, _), moment in self.motion.moments.items():
            if moment[frame] > 0.0:
                place, along = touching_place(self.motion.points[frame], joint)
                (dot,) = self.scene.plot(*place, "o", color=FORCE, markersize=9)
                yield dot
                across = np.array([along[1], -along[0]])
                yield from self._told(force_text(moment[frame], "N m"), place + 0.11 * side * across)
                dot.remove()

    def _told(self, content: str, place: np.ndarray) -> Iterable[Artist]:
        """A text at a place."""
        x, y = place
        look: dict[str, Any] = {"color": FORCE, "fontweight": "bold", "ha": "center", "va": "center"}
        text = self.scene.text(x, y, content, **look)
        text.set_path_effects([withStroke(linewidth=3.0, foreground="white")])
        yield text
        text.remove()
