"""The figure on which a film's frames are drawn: chain, trace, walls, arrows of forces, clock, charts.

A small figure, or one for a recording without energies, has no charts.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon

from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.colours import (
    INK,
    LOAD,
    OUTSIDE_COLOUR,
    PALE_GREY,
    PEAK_COLOUR,
    TIME_COLOURS,
)
from chain_impact.pictures.drawing.dark_ground import Ground
from chain_impact.pictures.drawing.style import STYLE
from chain_impact.pictures.film.arrow_numbers import Number, without_equals, write_numbers
from chain_impact.pictures.film.arrow_scale import FORCE, TITLE_MIDDLE, ArrowScale, arrow_between, draw_key
from chain_impact.pictures.film.caption import Caption
from chain_impact.pictures.film.charts import add_veil, draw_charts, largest_forces, largest_wall_force
from chain_impact.pictures.film.film_layout import SIZE_WITH_CHARTS, layout_for
from chain_impact.pictures.film.impact_rings import ImpactRings
from chain_impact.pictures.film.scale_bar import NUMBER_SIZE, draw_scale_bar
from chain_impact.pictures.film.tip_trace import trace_of
from chain_impact.pictures.motion.bodies import FILL, body_look, draw_rail
from chain_impact.pictures.motion.motion import colour_of_time
from chain_impact.pictures.motion.walls import draw_pin, draw_room, has_motion
from chain_impact.pictures.over_time.energies import ENERGIES
from chain_impact.recording.interactions import FRICTION, JOINT_STOP
from chain_impact.recording.joint_stops import range_lines, stop_mark
from chain_impact.recording.pacing import SLOW_RATE, TAIL, rate_text
from chain_impact.recording.recording import Recording
from chain_impact.recording.view import film_view, pin_lines, positions_of, radius_of
from chain_impact.scene.display.outlines import placed_corners
from chain_impact.scene.half_planes import HalfPlane

MUTED = "#566076"
SHOWN_TIMES = 24  # the number of colours of time in a gif
FILM_COLOURS: tuple[Any, ...] = (
    INK,
    MUTED,
    PALE_GREY,
    OUTSIDE_COLOUR,
    FORCE,
    LOAD,
    PEAK_COLOUR,
    *ENERGIES.values(),
)
FILM_COLOURS += tuple(TIME_COLOURS(part) for part in np.linspace(0.0, 1.0, SHOWN_TIMES).tolist())
"""All colours of a film, except white and the shades between the colours and white.

Chain and path of the tip have the colours of time, as in the picture of a run.
"""
FILM_STYLE: Any = STYLE | {"text.color": INK, "axes.edgecolor": MUTED, "axes.labelcolor": INK}
TICK_STYLE = {"color": MUTED, "labelcolor": INK, "labelsize": NUMBER_SIZE}
FILM_STYLE |= {f"{axis}tick.{key}": value for axis in "xy" for key, value in TICK_STYLE.items()}
"""Settings of matplotlib for a film."""
# half of the length of the bar along a wall that marks a sticking contact, relative to the smaller side of
# the view
HALF_BAR = 0.035
SCALE = 0.055  # the position of the rulers, above the foot of the figure, relative to the figure's height
TAIL_PARTS = 40  # the number of pieces of the fading trace of the tip


class Film:
    """The figure on which the frames of a film are drawn, one after the other (``show``)."""

    def __init__(
        self, figure: Figure, recording: Recording, times: np.ndarray, ground: Ground | None = None
    ) -> None:
        """Draw the parts that do not move, and prepare the other parts for ``show``.

        Args:
            figure: an empty figure.
            recording: the recording to show.
            times: the time of the recording that each of the F frames shows [s], shape (F,).
            ground: the colours of the style in use, if the style is dark; else None.
        """
        self.recording, self.times, self.ground = recording, times, ground
        steps = np.diff(times).clip(1e-4, 0.01)  # the clock has 2 to 4 decimals
        self.decimals = int(np.ceil(-np.log10(steps.min(initial=0.01))))
        self.points = np.stack(
            [self._frame_values(point) for point in recording.all_points.transpose(1, 0, 2)], axis=1
        )
        self.joint_forces = {
            joint: self._frame_values(force) for joint, force in recording.joint_forces.items()
        }
        self.rows = np.searchsorted(recording.time, times, side="right") - 1
        self.interactions, self.moving_artists = recording.interactions, list[Any]()
        self.numbers, self.arrows = list[Number](), list[np.ndarray]()
        is_wide = bool((figure.get_size_inches() > 0.99 * np.array(SIZE_WITH_CHARTS)).all())
        self.tells_energies = is_wide and bool(recording.energies)
        radius = radius_of(recording)
        framing = film_view(positions_of(recording), recording.walls, radius, is_pinned=recording.pinned)
        layout = layout_for(figure, framing[0], is_wide=is_wide, has_charts=self.tells_energies)
        self.scene, sizes = figure.add_axes(layout.scene), (13, 15) if is_wide else (10, 10)
        title = figure.text(
            layout.scene[0], TITLE_MIDDLE, recording.name, fontsize=sizes[0], fontweight="bold", va="center"
        )
        artist_style: dict[str, Any] = {"animated": True, "va": "center"}
        self.clock = figure.text(*layout.clock, "", fontsize=sizes[1], fontweight="bold", **artist_style)
        self.rate = figure.text(*layout.rate, "", fontsize=10, **artist_style)
        listed_times = times if self.tells_energies else times[:0]
        self.caption = Caption(figure, layout.caption, recording, listed_times)
        self.side = self._draw_ground(*framing)
        self.cursors, self.peak_names = (
            draw_charts(figure, recording, times, self.caption.lowest, layout.wider)
            if self.tells_energies
            else ([], [])
        )
        line: dict[str, Any] = {"animated": True, "solid_capstyle": "round", "solid_joinstyle": "round"}
        self.trace_times, self.path = trace_of(recording, self.side)
        self.shade = colour_of_time(recording)
        self.trace_colours = self._time_colours(self.trace_times)
        self.rings = ImpactRings(self.scene, recording)
        self.trace = LineCollection([], linewidths=1.0, alpha=0.8 if ground else 0.55, animated=True)
        self.tail = LineCollection([], animated=True)
        self.ranges = LineCollection([], colors=MUTED, linewidths=1.2, animated=True)
        for lines in (self.trace, self.tail, self.ranges):
            self.scene.add_collection(lines, autolim=False)
        self._add_bodies(radius)
        (self.chain,) = self.scene.plot([], [], linewidth=4.0, **line)
        mark: dict[str, Any] = {"linestyle": "", "marker": "o", "animated": True}
        self.sites, self.joints, self.tip = (
            self.scene.plot([], [], color="white", markeredgecolor="white", markersize=size, **mark)[0]
            for size in (4, 5, 7)
        )
        self.veils = [add_veil(cursor.axes, is_dark=bool(ground)) for cursor in self.cursors]
        forces = largest_forces(recording)
        peak = max(largest_wall_force(recording, forces), forces.get("joint", np.zeros(1)).max())
        self.scale = ArrowScale(peak, self.side)
        if peak > 0.0:
            self.scale.draw(self.scene, SCALE, MUTED)
        if self.joint_forces:
            draw_key(figure, title, 0.99 if not is_wide else layout.scene[0] + layout.scene[2])
        self._suit(figure)

    def _add_bodies(self, radius: float) -> None:
        """Add discs, outlines and the carriage; ``radius`` is the result of ``radius_of``."""
        body: dict[str, Any] = {**body_look(INK), "animated": True}
        radii = self.recording.touching_radii if radius > 0.0 else {}
        self.discs = {point: Circle((0, 0), r, animated=True) for point, r in radii.items()}
        self.bodies = {link: Polygon(corners, **body) for link, corners in self.recording.outlines.items()}
        base = {**body, "facecolor": to_rgb(PALE_GREY)}
        rail = self.recording.rail
        self.carriage = [(Polygon(np.zeros((4, 2)), **base), rail)] if rail else []
        self.patches = [*self.discs.values(), *self.bodies.values(), *(patch for patch, _ in self.carriage)]
        for patch in self.patches:
            self.scene.add_patch(patch)

    def _suit(self, figure: Figure) -> None:
        """Give the figure the colours for a dark ground, if the style in use is dark."""
        if self.ground:
            self.ground.suit(figure.findobj())
            figure.set_facecolor(self.ground.ground)

    def _frame_values(self, vectors: np.ndarray) -> np.ndarray:
        """Return vectors at the times of the frames, shape (F, 2), interpolated between rows, (T, 2)."""
        return np.stack([np.interp(self.times, self.recording.time, part) for part in vectors.T], axis=-1)

    def _draw_ground(self, view: np.ndarray, anchor: np.ndarray) -> float:
        """Draw walls, rail, pin and ruler in a view; return the length [m] of the view's shorter side."""
        pinned = self.recording.pinned
        # the axes have equal scales along x and y, so they also show room beside, above or below the view
        room, size = self.scene.get_window_extent().size, np.ptp(view, axis=0)
        seen_size = room * (size / room).max()
        lower_corner = view[0] - anchor * (seen_size - size)
        self.scene.set(xticks=[], yticks=[])
        self.scene.spines[:].set_visible(False)
        self.view = lower_corner + np.array([np.zeros(2), seen_size])
        self.pin = pin_lines(self.recording.all_points) if pinned else []
        self.room_moves = bool(self.recording.moved_walls) or (
            pinned and has_motion(self.recording.points[:, 0])
        )
        rail_lines = draw_rail(self.scene, self.recording)
        self.rail = [line for lines in rail_lines for line in lines.get_segments()]
        self.room = self._draw_room(0)
        for artist in self.room if self.room_moves else ():
            artist.set_animated(True)
        draw_scale_bar(self.scene, SCALE, MUTED)
        return float(min(np.ptp(view, axis=0)))

    def _draw_room(self, frame: int) -> list[Artist]:
        walls = list(self.recording.walls_at(float(self.times[frame])).values())
        way = self.points[frame, 0] - self.recording.points[0, 0]
        pin = draw_pin(self.scene, [line + way for line in self.pin])
        return [*draw_room(self.scene, self.view, walls), *pin]

    def _moved_room(self, frame: int) -> list[Artist]:
        """Draw walls and the base's mark anew for a frame; return the artists; [] if neither ever moves."""
        if not self.room_moves:
            return []
        for artist in self.room:
            artist.remove()
        self.room = self._draw_room(frame)
        if self.ground:
            self.ground.suit(self.room)
        return self.room

    def show(self, frame: int, rate: float) -> Iterable[Artist]:
        """Move chain, walls, forces and texts to a frame; yield the artists to draw, in order.

        Nothing moves before the result is iterated over.

        Args:
            frame: the index of the frame, from 0.
            rate: simulated seconds per second on the screen.
        """
        time, positions = self.times[frame], self.points[frame]
        points = positions[: self.recording.link_count + 1]
        passed_rows = np.searchsorted(self.trace_times, time, side="right")
        tip_path = np.append(self.path[:passed_rows], points[-1:], axis=0)
        self.trace.set_segments(list(np.stack([tip_path[:-1], tip_path[1:]], axis=1)))
        self.trace.set_color(self.trace_colours[:passed_rows])
        self._show_tail(time)
        self._colour_chain(time)
        for point, disc in self.discs.items():
            disc.set_center(tuple(positions[point]))
        for link, body in self.bodies.items():
            body.set_xy(placed_corners(self.recording.outlines[link], points[link - 1], points[link]))
        for carriage, rail in self.carriage:
            carriage.set_xy(rail.carriage(points[0]))
        self.sites.set_data(*positions[len(points) :].T)
        self.chain.set_data(*points.T)
        self.joints.set_data(*points[:-1].T)
        self.tip.set_data(*points[-1:].T)
        self.clock.set_text(f"{time:.{self.decimals}f} s")
        self.rate.set_text(rate_text(rate))
        self.caption.show(frame)
        self.rate.set_color(self._suited_colour(INK if rate < SLOW_RATE else MUTED))
        self.ranges.set_segments(list(range_lines(points, self.recording.stops)))
        yield from self._moved_room(frame)
        yield from (self.trace, self.tail, *self.rings.show(time), *self.patches, self.ranges)
        yield from (self.chain, self.sites, self.joints, self.tip)
        yield from self._forces(frame, tip_path)
        yield from (self.clock, self.rate, self.caption.text)
        for veil, cursor in zip(self.veils, self.cursors, strict=True):
            cursor.set_xdata([time, time])
            veil.set_x(time)
            veil.set_width(max(0.0, self.recording.time[-1] - time))
        yield from (*self.veils, *self.peak_names, *self.cursors)

    def _time_colours(self, times: np.ndarray) -> list[Any]:
        """Return the colours of some times [s]; none for no times."""
        colours = np.reshape(self.shade(times), (-1, 4)).tolist()
        return [self._suited_colour(colour) for colour in colours]

    def _colour_chain(self, time: float) -> None:
        """Give the chain, its bodies and its points the colour of a time [s]."""
        (colour,) = self._time_colours(np.array([time]))
        self.chain.set_color(colour)
        for line in (self.sites, self.joints):
            line.set_markeredgecolor(colour)
        for line in (self.sites, self.tip):
            line.set_markerfacecolor(colour)
        for patch in (*self.discs.values(), *self.bodies.values()):
            patch.set(edgecolor=colour, facecolor=(*to_rgb(colour), FILL))
        for patch, _ in self.carriage:
            patch.set_edgecolor(colour)

    def _show_tail(self, time: float) -> None:
        moments = np.linspace(max(time - TAIL, self.times[0]), time, TAIL_PARTS + 1)
        tip = np.stack([np.interp(moments, self.trace_times, x) for x in self.path.T], axis=-1)
        self.tail.set_segments(list(np.stack([tip[:-1], tip[1:]], axis=1)))
        self.tail.set_color(self._time_colours(moments[1:]))
        self.tail.set_alpha(list(np.linspace(0.0, 1.0, TAIL_PARTS)))
        self.tail.set_linewidth(list(np.linspace(0.5, 2.2, TAIL_PARTS)))

    def _forces(self, frame: int, tip_path: np.ndarray) -> Iterator[Artist]:
        """Draw and yield the forces in a frame; numbers keep off the path of the tip, shape (P, 2) [m].

        A force has an arrow, and a contact that sticks a bar along the wall. A moment at a stop of a joint
        has a mark, and so has a joint or slider that sticks. If there is room, numbers tell the forces at
        walls and stops of the slider, the moments, and the largest force in a joint.
        """
        for artist in self.moving_artists:
            artist.remove()
        self.moving_artists.clear()
        self.numbers.clear()
        self.arrows.clear()
        planes = self.recording.sides_at(float(self.times[frame]))
        for interaction in self.interactions:
            force = 0.0 if interaction.force is None else self._value_at(interaction.force, frame)
            is_stuck = interaction.sticking is not None and interaction.sticking[self.rows[frame]] > 0.0
            if interaction.wall in planes and force > 0.0:
                course = interaction.friction
                friction = 0.0 if course is None else self._value_at(course, frame)
                point, plane = self.points[frame, interaction.point], planes[interaction.wall]
                self._add_contact(point, plane, (force, friction), is_stuck)
            elif interaction.kind == FRICTION and is_stuck:
                joint = self.points[frame, max(interaction.point - 1, 0)]
                self._add_line(joint, "o", markeredgecolor=INK, markersize=7)
            elif interaction.kind == JOINT_STOP and force > 0.0:
                mark, (dx, dy) = stop_mark(self.points[frame], interaction.point)
                self._add_line(mark, "o", markersize=9)
                tangent = np.array([dy, -dx])
                self.numbers.append(Number(force, force_text(force, "N·m"), mark, tangent, FORCE))
        self._add_loads(frame)
        numbers = without_equals(self.numbers)
        self.moving_artists += write_numbers(self.scene, numbers, self._outlines(frame), tip_path)
        if self.ground:
            self.ground.suit(self.moving_artists)
        yield from self.moving_artists

    def _suited_colour(self, colour: Any) -> Any:
        """Return the colour that replaces ``colour`` if the ground is dark; else ``colour`` itself."""
        return self.ground.suited_colour(colour) if self.ground else colour

    def _add_loads(self, frame: int) -> None:
        """Add an arrow for the force in each joint in a frame; a number is wanted for the largest only.

        A force that is too small for ``ArrowScale.is_shown`` has neither arrow nor number.
        """
        forces = {joint: force[frame] for joint, force in self.joint_forces.items()}
        peak_joint = max(forces, key=lambda joint: np.hypot(*forces[joint]), default=0)
        for joint, force in forces.items():
            size = float(np.hypot(*force))
            if size > 0.0 and self.scale.is_shown(size):
                joint_position = self.points[frame, joint - 1]
                self._add_arrow(joint_position, force / size, size, LOAD, with_size=joint == peak_joint)

    def _value_at(self, column: np.ndarray, frame: int) -> float:
        return float(np.interp(self.times[frame], self.recording.time, column))

    def _add_contact(
        self, point: np.ndarray, plane: HalfPlane, force: tuple[float, float], is_stuck: bool
    ) -> None:
        """Add the arrow of the contact force on a point; if the contact sticks, also a bar along the wall.

        A force that is too small for ``ArrowScale.is_shown`` has no arrow.

        Args:
            point: position of the point [m].
            plane: the free side of the wall.
            force: the normal and the tangential part of the force [N], along the wall's normal and tangent.
            is_stuck: whether the contact sticks.
        """
        normal = np.array(plane.normal)
        tangent = np.array([normal[1], -normal[0]])
        foot, force_size = point - plane.clearance(*point) * normal, float(np.hypot(*force))
        if is_stuck:
            bar = np.stack([foot - HALF_BAR * self.side * tangent, foot + HALF_BAR * self.side * tangent])
            self._add_line(bar.T, linewidth=3.0, solid_capstyle="butt")
        if self.scale.is_shown(force_size):
            self._add_arrow(foot, (force[0] * normal + force[1] * tangent) / force_size, force_size, FORCE)

    def _add_arrow(
        self, foot: np.ndarray, direction: np.ndarray, force_size: float, colour: str, with_size: bool = True
    ) -> None:
        """Add the arrow of a force.

        Args:
            foot: the start of the arrow [m].
            direction: unit vector of the force.
            force_size: the size of the force [N].
            colour: the colour of the arrow.
            with_size: whether the size is also written at the arrow's head.
        """
        head = foot + self.scale.length(force_size) * direction
        self.moving_artists.append(self.scene.add_patch(arrow_between(self.scene, foot, head, colour)))
        self.arrows.append(np.stack([foot, head]))
        if with_size:
            self.numbers.append(Number(force_size, force_text(force_size, "N"), head, direction, colour))

    def _add_line(self, points: np.ndarray, *marker: str, **style: Any) -> None:
        self.moving_artists += self.scene.plot(*points, *marker, color=FORCE, **style)

    def _outlines(self, frame: int) -> list[np.ndarray]:
        """Return the lines that numbers in a frame must not cover: chain, bodies, walls, rail and arrows."""
        bodies = [*self.bodies.values(), *(patch for patch, _ in self.carriage)]
        outlines = [np.asarray(body.get_xy()) for body in bodies]
        for disc in self.discs.values():
            outlines.append(np.asarray(disc.get_patch_transform().transform(disc.get_path().vertices)))
        walls = [np.asarray(line.get_xydata()) for line in self.room if isinstance(line, Line2D)]
        chain = self.points[frame, : self.recording.link_count + 1]
        return [chain, *outlines, *walls, *self.rail, *self.arrows]
