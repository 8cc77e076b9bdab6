"""The methods of a result that give derivatives, draw pictures and write an animation."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from chain_impact.recording.curves import Curves, curves_of, impact_numbers
from chain_impact.recording.impact_course import ImpactCourse, RepeatableRun, course_of
from chain_impact.recording.passed_walls import points_through_walls
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.results.ranking import Ranking, ranking_of
from chain_impact.scene.candidates import point_wall_pairs, wall_numbers
from chain_impact.scene.errors import UnknownNameError, names_matching
from chain_impact.scene.scene import Scene
from chain_impact.variables.prepared import PreparedScene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from chain_impact.pages.inline import InlinePage
    from chain_impact.pictures.drawing.sizes import Size


class SceneRecording(Recording):
    """A result with methods for derivatives, pictures and an animation; ``Result`` has its attributes."""

    prepared_scene: PreparedScene
    statistics: dict[str, int]
    rerun: RepeatableRun | None

    @property
    def scene(self) -> Scene:
        """The scene as it was simulated."""
        return self.prepared_scene.scene

    @cached_property
    def points_through_walls(self) -> list[str]:
        """Sentences on points that pass through walls without touching them.

        The list is empty if ``simulate(output=…)`` left out positions of points.
        """
        walls = {
            number: (name, self.walls[name], self.moved_walls.get(name, 0.0))
            for name, number in wall_numbers(self.scene).items()
            if name in self.walls
        }
        try:
            positions = self.all_points
        except UnknownNameError:  # the positions of points were left out of the result
            return []
        return points_through_walls(positions, walls, set(point_wall_pairs(self.scene)))

    def plot(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        kind: str | None = None,
        size: Size | None = None,
        panels: str | Sequence[str] = (),
        curves: str | Sequence[str] = (),
        around: int | None = None,
        title: str | None = "",
        ax: Any = None,
    ) -> Any:
        """Draw motion, energy and impacts, or any outputs over time.

        The panel ``motion`` shows only the rows of this result: if ``output_step`` is coarse, a path has
        straight parts between rows. ``chain-impact simulate`` with ``--plot`` or ``--show`` simulates once
        more, with more rows, if there are fewer than 1000 rows.

        Fonts follow matplotlib's settings and style sheets. In a dark style the picture is dark.

        Args:
            path: a file; its suffix png, svg or pdf determines the kind. Without a file the figure is
                returned, for a notebook; ``figure.axes`` have the names of panels as labels.
            kind: the name of a single panel, in place of ``panels``.
            size: width and height [inches]; with the height None, the contents determine the height. A slim
                motion stands beside the other panels, a broad one above them; a ball on a straight line is
                drawn over time.
            panels: some of ``motion``, ``impact`` (the force of the hardest impact over its time),
                ``energy``, ``impacts`` and ``friction``; by default those for which the result has data, but
                for a single impact only one of ``impact`` and ``impacts``.
            curves: outputs by their names in the FMU, ``*`` for any text: ``["contact[*].y_min.force",
                "point[4].y"]``. They are drawn in place of the panels, with a panel for each unit, or for
                each quantity of a unit with many curves. The run is repeated with more rows within impacts.
            around: the number of an impact, from 1, with ``curves`` only: the curves show only this impact
                and the time around it.
            title: the title of the picture, by default the impact in view or a summary of the run; None for
                no title.
            ax: axes of matplotlib to draw into, one for each panel; without ``panels`` or ``kind``, axes for
                ``motion`` alone. The axes are returned, and smaller if their figure would cut off labels.

        Raises:
            ValueError: when a panel or an impact does not exist, the picture is smaller than 2 by 2 inches or
                has no room for the panels, or two arguments exclude each other, as ``ax`` and ``path``.
            UnknownNameError: when ``simulate(output=…)`` left out an output that is drawn.
            OSError: when the file cannot be written.
        """
        from chain_impact import pictures  # matplotlib is imported here, because this takes a second

        if curves:
            drawn_curves = self.curves([curves] if isinstance(curves, str) else curves, around)
            return self._plot_curves(drawn_curves, path, size, title, ax)
        if around is not None:
            raise ValueError(f"around = {around!r}: only curves are drawn around an impact")
        given_options = [name for name, value in (("kind", kind), ("panels", panels)) if value]
        if len(given_options) > 1:
            raise ValueError(f"kind = {kind!r} and panels = {panels!r}: one of them must be left out")
        shown_panels = [kind] if kind else [panels] if panels and isinstance(panels, str) else panels
        if self.scene.outputs.energies or "energy" in shown_panels:
            # raises an error if the result lacks the outputs of energy
            names_matching(
                self.name, "energy.kinetic", self.columns, "not an output of this result", self.output_hint
            )
        if ax is None:
            return pictures.overview_picture(self, shown_panels, size, title).plot(path, size=size)
        pictures.check_alone(path, size)
        pictures.draw_panels(ax, self, shown_panels or ["motion"])
        return ax

    def _plot_curves(
        self,
        curves: Curves,
        path: str | os.PathLike[str] | None,
        size: Size | None,
        title: str | None,
        ax: Any,
    ) -> Any:
        """Draw curves in place of panels, with the arguments and the result of ``plot``."""
        from chain_impact import pictures

        if ax is None:
            return pictures.curves_picture(self, curves, title).plot(path, size=size)
        pictures.check_alone(path, size)
        pictures.draw_curve_panels(np.ravel(ax).tolist(), self, curves)
        return ax

    def curves(self, names: Sequence[str], around: int | None = None) -> Curves:
        """Return the curves of outputs for ``plot(curves=…)``, with more times if the run can be repeated."""
        return curves_of(self, names, self.prepared_scene.units, around=around, rerun=self.rerun)

    @cached_property
    def detailed_energies(self) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
        """Times [s], shape (T,), and ``energies`` at these times.

        If the run can be repeated, these are the times of the rows and many times within each impact, because
        curves through the rows alone would miss the largest elastic energy of short impacts.
        """
        if self.rerun is None:
            return self.time, self.energies
        energy_curves = self.curves([f"energy.{name}" for name in self.energies])
        return energy_curves.time, {
            name.partition(".")[2]: values for name, values in energy_curves.values.items()
        }

    def plot_impact(
        self,
        number: int,
        path: str | os.PathLike[str] | None = None,
        *,
        size: Size | None = None,
        ax: Any = None,
    ) -> Any:
        """Draw one impact: force, penetration and speed over time, and force over penetration.

        The picture gives the realised restitution, and the energy that the whole chain lost during the
        impact. If the contact lasts long, the curves over time show only its first part, with the peak of the
        force. Rows are usually farther apart than an impact is long, so the run is repeated up to the end of
        the impact, with rows within the impact. The repeated run is identical bit by bit, because additional
        rows do not change the solution.

        Args:
            number: the number of the impact, from 1, as in pictures and tables.
            path: as for ``plot``.
            size: as for ``plot``.
            ax: axes of matplotlib, into which only the curve of the force over the penetration is drawn. The
                axes are returned.

        Raises:
            ValueError: when the impact does not exist, the result is not from ``simulate`` or
                ``record_slowly``, or as for ``plot``.
            OSError: when the file cannot be written.
        """
        from chain_impact import pictures

        course = self.course_of_impact(number)
        impact = self.impacts[number - 1]
        if ax is None:
            return pictures.impact_picture(self, number, course).plot(path, size=size)
        pictures.check_alone(path, size)
        pictures.draw_loop_panel(ax, impact, course, is_at_stop=self.is_joint_stop(impact["wall"]))
        return ax

    def course_of_impact(self, number: int) -> ImpactCourse:
        """Return force, penetration and speed over time of an impact, by its number from 1 (``plot_impact``).

        Raises:
            ValueError: when the impact does not exist, or the run cannot be repeated.
        """
        if not 1 <= number <= len(self.impacts):
            raise ValueError(f"{self.name}: number = {number!r} must be {impact_numbers(len(self.impacts))}")
        if number not in self._courses:
            impact, end_time = self.impacts[number - 1], float(self.time[-1])
            self._courses[number] = course_of(self.prepared_scene, self.rerun, impact, end_time=end_time)
        return self._courses[number]

    @cached_property
    def _courses(self) -> dict[int, ImpactCourse]:
        """Number of an impact → its course, for the courses that ``course_of_impact`` has computed so far."""
        return {}

    def sensitivity(self, quantity: str, parameter: str) -> np.ndarray:
        """Return the partial derivative of an output with respect to a parameter.

        Args:
            quantity: an output by its name in the FMU: ``"point[4].x"``.
            parameter: one of the parameters in ``simulate(sensitivities=…)``: ``"contact.stiffness"``.

        Returns:
            Shape (T,), in the unit of the output divided by the unit of the parameter. NaN where the
            derivative does not exist or cannot be trusted; ``sensitivity_limits`` gives the reason.
            ``chain_impact.kernel.tangent.replay`` describes the method.

        Raises:
            UnknownNameError: when the result has no derivatives for one of the names.
        """
        return self._derivatives.output_derivatives(quantity, parameter)

    def impact_sensitivity(self, quantity: str, parameter: str) -> np.ndarray:
        """Return the derivative of a quantity of the impacts, as ``sensitivity`` does, shape (len(impacts),).

        Args:
            quantity: onset, end, impact_speed, separation_speed, peak_force, max_penetration, effective_mass,
                impulse, joint_force, x or y.
            parameter: one of the parameters in ``simulate(sensitivities=…)``.

        Raises:
            UnknownNameError: when the result has no derivatives for one of the names.
        """
        return self._derivatives.impact_derivatives(quantity, parameter)

    def ranking(self, quantity: str, parameters: str | Sequence[str] = "*") -> Ranking:
        """Return parameters and inputs in the order of their effects on a quantity, the largest effect first.

        The effect of a parameter is the change of the quantity, to first order, when the value of the
        parameter changes by 1 %. A parameter with the value 0 changes by 0.01 of its unit, and comes last.

        Args:
            quantity: the name of one of three kinds of quantity. The first is the largest value in the run,
                by its name in a sweep: ``peak_force`` and ``max_penetration`` at walls, ``stop.peak_moment``
                and ``stop.max_penetration`` at stops of joints, ``joint_force`` in joints, if the scene asks
                for loads. The second is a quantity of one impact, such as ``impact[2].peak_force``; impacts
                count from 1, in the order of ``impacts``. The third is an output, of which the value at the
                end counts.
            parameters: the names to rank; ``*`` stands for any text. But ``contact.exponent`` and
                ``stop.exponent`` must be named in full, because they change the unit of the stiffness.

        Raises:
            SceneError: when the quantity does not exist, or the run does not have the quantity.
            UnknownNameError: when the run had no derivatives, or none for one of the parameters.
        """
        return ranking_of(self, self._derivatives, quantity, parameters)

    @property
    def sensitivity_limits(self) -> tuple[str, ...]:
        """Sentences: which derivatives are NaN or one-sided, from when on and why, and errors by friction.

        The tuple is empty if all derivatives exist, are two-sided and can be trusted, or if the run had none.
        """
        return self.sensitivities.limits if self.sensitivities else ()

    def plot_sensitivities(
        self,
        path: str | os.PathLike[str] | None = None,
        outputs: Sequence[str] = (),
        *,
        size: Size | None = None,
    ) -> Figure | None:
        """Draw the changes of outputs, and of the peak forces of impacts, if each parameter grows by 1 %.

        The changes are of first order: the derivative times 1 % of the parameter, or times 0.01 of the
        parameter's unit if its value is zero. An exponent is drawn only if the run's ``sensitivities`` name
        it in full, because it changes the unit of the stiffness.

        Args:
            path: as for ``plot``.
            outputs: outputs by their names in the FMU; by default the position of the tip, and the total
                energy.
            size: as for ``plot``.

        Raises:
            ValueError: when the size is not possible, or has no room for the panels.
            UnknownNameError: when the run had no derivatives, or ``simulate(output=…)`` left out an output
                that is drawn.
            OSError: when the file cannot be written.
        """
        from chain_impact import pictures

        names = self._derivatives.drawn(outputs)
        return pictures.sensitivities_picture(self, names).plot(path, size=size)

    def animate(self, path: str | os.PathLike[str] | None = None, **options: Any) -> InlinePage | None:
        """Write an animation: a page for the browser, ``.html``, or a film, ``.gif`` or ``.mp4``.

        The animation shows an impact only by the rows within the impact. ``record_slowly`` simulates a scene
        with more such rows.

        Args:
            path: the file. Without a file the page is returned, for a notebook.
            options: ``speed``, ``impact_time``, ``size``, ``progress`` of ``chain_impact.animate``.

        Raises:
            UnknownNameError: when ``simulate(output=…)`` left out the positions of the points.
            AnimationError, MissingExtraError, OSError: as ``chain_impact.animate``.
        """
        from chain_impact.results.animation import write_animation

        return write_animation(self, path, **options)

    @property
    def _derivatives(self) -> Sensitivities:
        """The derivatives of the run; if there are none, reading this raises an error."""
        if self.sensitivities is None:
            hint = "simulate(scene, sensitivities=[…]) makes them"
            raise UnknownNameError(self.name, "sensitivity", (), "not in this result", hint)
        return self.sensitivities
