"""The model: a scene compiled once into what all others ask for.

That is its candidates, the variables of its FMU by name, their places in the instance record
(kernel/record/), and new instances with its parameters in their places.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from chain_impact.kernel.integration.methods import SOLVER_METHODS
from chain_impact.kernel.integration.sundman import NO_CONTACT
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.model.contact_law import USER_LAW
from chain_impact.kernel.model.derived import DERIVED
from chain_impact.kernel.model.geometry import WALLS
from chain_impact.kernel.tangent.directions import DIRECTIONS, tangent_dtype
from chain_impact.scene.candidates import candidates
from chain_impact.scene.names import Place, friction_hint, input_key, parameter_hint
from chain_impact.scene.reading import matching
from chain_impact.scene.scene import Scene
from chain_impact.variables.outputs import all_outputs, shape_of
from chain_impact.variables.places import OutputPlaces, layout_of, output_places
from chain_impact.variables.table import BEHIND, WORD, derivatives, first_word, inputs, parameters, word_index
from chain_impact.variables.variable import Variable, variable_row

LINK_PARAMETERS = (
    *("length", "mass", "center_of_mass", "inertia"),
    *("joint_damping", "joint_stiffness", "joint_rest_angle", "joint_friction"),
)


class Model:
    """A scene with all that follows from it, each part worked out once, most of them when first asked for.

    Attributes:
        scene: what the model is of.
        candidates: the C pairs (point, or joint of a stop; index into ``scene.wall_names``) that can touch.
        sizes: of a record: links, candidates, elements.
        layout: the record of an instance without derivatives.
        row: the record of the outputs, a row of ``Result.outputs``.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.candidates = scene, candidates(scene)
        links, pairs = len(scene.chain.links), len(self.candidates)
        self.sizes = links, pairs, links + pairs if scene.has_friction else 0
        self.layout = layout_of(*self.sizes)
        self.row: np.dtype = self.layout["output"]

    def __eq__(self, other: object) -> bool:
        """Whether it is the model of an equal scene."""
        return self.scene == other.scene if isinstance(other, Model) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[type[Model], tuple[Scene]]:
        """So that what follows from the scene does not go to another process."""
        return type(self), (self.scene,)

    @cached_property
    def parameters(self) -> list[Variable]:
        """The parameters of the FMU."""
        return list(parameters(self.scene))

    @cached_property
    def inputs(self) -> list[Variable]:
        """The inputs of the FMU."""
        return list(inputs(self.scene))

    @cached_property
    def outputs(self) -> list[Variable]:
        """The outputs of the FMU, but for derivatives."""
        return list(self._own_outputs.values())

    @cached_property
    def _own_outputs(self) -> dict[str, Variable]:
        """The outputs of the FMU, but for derivatives, by their names."""
        return all_outputs(self.scene)

    @cached_property
    def outputs_by_name(self) -> dict[str, Variable]:
        """The outputs of the FMU, derivatives among them, by their names."""
        return {variable.name: variable for variable in self.variables if variable.causality == "output"}

    @cached_property
    def units(self) -> dict[str, str]:
        """Name of a variable of the FMU → its unit."""
        return {variable.name: variable.unit for variable in self.variables}

    @cached_property
    def motion(self) -> list[Variable]:
        """The outputs that change all the time: those of ``Result.outputs``."""
        return [variable for variable in self.outputs if variable.place[0] == "output"]

    @cached_property
    def varied(self) -> list[Variable]:
        """The parameters and inputs with respect to which the FMU has derivatives.

        Raises:
            UnknownNameError: when the scene names one without.
        """
        names = self.scene.outputs.sensitivities
        return self.varied_by(names) if names else []

    @cached_property
    def variables(self) -> list[Variable]:
        """All variables of the FMU, in the order of their value references: outputs come last."""
        return [*self.parameters, *self.inputs, *self.outputs, *derivatives(self.motion, self.varied)]

    @cached_property
    def parameter_paths(self) -> dict[str, Place]:
        """The names of the parameters, and the paths that ``scene.with_values`` takes for them.

        Where the FMU takes the number of a choice, the scene takes its name: ``contact.model`` a law's id.
        """
        return {v.name: v.scene_path for v in self.parameters if v.scene_path is not None}

    @cached_property
    def differentiable(self) -> dict[str, Variable]:
        """The parameters and inputs with respect to which there are derivatives, by their names."""
        left_out = ("minimum_impact_speed", "contact.model")
        variables = (*self.parameters, *self.inputs)
        return {v.name: v for v in variables if not v.name.startswith("solver") | v.name.endswith(left_out)}

    @cached_property
    def start(self) -> np.ndarray:
        """An instance as the FMU has it before it is initialized; not to be written to."""
        start = self.new_instance()
        start.flags.writeable = False
        return start

    def word(self, variable: Variable) -> int:
        """Where a variable is in an instance of the FMU, counted in words."""
        return word_index(self.start.dtype, variable.place)

    def table_row(self, variable: Variable) -> list[Any]:
        """What an importer has to know of a variable, as ``variable_row`` gives it."""
        words = (word_index(self.start.dtype, place) for place in (variable.place, variable.set_place))
        return variable_row(variable, *words)

    def start_text(self, variable: Variable) -> str:
        """The start value of a variable, as the shortest text that reads back as the same number."""
        words = self.start.view(np.float64 if variable.type == "real" else np.int64)
        return repr(words[self.word(variable)].item())

    @cached_property
    def columns(self) -> dict[str, int]:
        """The outputs that change all the time: name → index into a row."""
        return {variable.name: word_index(self.row, variable.place[1:]) for variable in self.motion}

    @cached_property
    def output_words(self) -> np.ndarray:
        """Which numbers of the record are those of a row, shape (W,)."""
        first = first_word(self.layout, "output")
        return np.arange(first, first + self.row.itemsize // WORD)

    def varied_by(self, names: str | Iterable[str]) -> list[Variable]:
        """The parameters and inputs of some names, in which ``*`` stands for any text, each of them once.

        Raises:
            UnknownNameError: when there is none of a name with respect to which there are derivatives.
        """

        def hint(name: str) -> str | None:
            if name in self.columns:
                return "it is an output: derivatives of it are with respect to parameters and inputs"
            if name in self.parameter_paths:
                return "it is a choice, or a setting of the solver, of which the motion is no smooth function"
            if key := input_key(name):
                return f"the scene does not have this input: it needs inputs.{key} = true"
            return friction_hint(name) or parameter_hint(name, len(self.scene.chain.links))

        wanted = (names,) if isinstance(names, str) else tuple(names)
        if not wanted:
            return []
        known, what = self.differentiable, "no parameter with derivatives"
        return [known[name] for name in self._named(wanted, known, what, hint)]

    def outputs_named(self, wanted: str | Iterable[str]) -> list[Variable]:
        """The outputs of some names or patterns, each of them once, in the order asked for.

        Raises:
            UnknownNameError: when there is none of a name, or like a pattern.
        """
        if not wanted:
            return []
        there = self._own_outputs
        return [there[name] for name in self._named(wanted, there, "no output")]

    @property
    def output_places(self) -> OutputPlaces:
        """Where in the record the outputs are."""
        return output_places(shape_of(self.scene), self.sizes)

    def places_named(self, wanted: str | Iterable[str]) -> OutputPlaces:
        """Those of the outputs of some names or patterns, each of them once, in the order asked for.

        Raises:
            UnknownNameError: when there is none of a name, or like a pattern.
        """
        names, (motion, stepwise) = [one.name for one in self.outputs_named(wanted)], self.output_places
        return OutputPlaces(
            {name: motion[name] for name in names if name in motion},
            {name: stepwise[name] for name in names if name in stepwise},
        )

    def columns_named(self, wanted: str | Iterable[str]) -> dict[str, int]:
        """Those of ``columns`` of some names or patterns.

        Raises:
            UnknownNameError: when there is none of a name, or like a pattern.
        """
        found = self._named(wanted, self.columns, "no output", elsewhere)
        return {name: self.columns[name] for name in found}

    def series(self, outputs: np.ndarray) -> dict[str, np.ndarray]:
        """The time series in ``Result.outputs`` under the names of the FMU's outputs: name → shape (T,)."""
        found = {}
        for variable in self.motion:
            values = outputs
            for name in variable.field.split("."):
                values = values[name]
            found[variable.name] = values[(..., *variable.index)]  # type: ignore[arg-type]
        return found

    def new_instance(self, varied: Sequence[Variable] | None = None) -> np.ndarray:
        """An instance with the parameters of the scene, not yet initialized; an array with one record.

        Behind the instance, in the same record, are those of dual numbers that the derivatives need.

        Args:
            varied: with respect to what there are derivatives; by default as in the FMU.
        """
        varied = self.varied if varied is None else varied
        block = np.zeros(1, self.layout)
        _fill(block[0], self.scene, self.candidates)
        block[0]["step"]["regularized"] = NO_CONTACT
        return _with_tangents(block, [variable.set_place for variable in varied]) if varied else block

    def _named(
        self,
        wanted: str | Iterable[str],
        there: Mapping[str, Any],
        what: str,
        hint: Callable[[str], str | None] = lambda _: None,
    ) -> dict[str, None]:
        """The names of what is there that are wanted, each once."""
        names = (wanted,) if isinstance(wanted, str) else wanted
        return {one: None for name in names for one in matching(self.scene.name, name, there, what, hint)}


def model_of(source: Scene | Model) -> Model:
    """The model itself, or that of a scene."""
    return source if isinstance(source, Model) else Model(source)


def elsewhere(name: str) -> str | None:
    """Where to find what the FMU tells in outputs, but a result does not tell over time."""
    if re.match(r"(impact|solver)\b", name):
        return "impacts are in result.impacts, counts of the solver in result.statistics"
    return None


def _fill(d: Any, scene: Scene, pairs: Sequence[tuple[int, int]]) -> None:
    """Put the parameters of a scene, and its candidates, in their places in a new instance."""
    links = scene.chain.links
    d["links"], d["candidates"] = len(links), len(pairs)
    d["elements"] = len(d["element"]["mode"])

    model = d["model"]
    model["gravity"] = scene.gravity
    for i, link in enumerate(links):
        for name in LINK_PARAMETERS:
            model[name][i] = getattr(link, name)
    model["joint_min"], model["joint_max"] = -math.inf, math.inf
    for w, name in enumerate(WALLS):  # the position of a wall that is not there is never read
        model["wall"][w] = getattr(scene.box, name) or 0.0
    if pairs:
        d["candidate"]["point"], d["candidate"]["wall"] = np.transpose(pairs)
    model["pinned"] = scene.chain.base == "pinned"
    model["driven"] = scene.inputs.joint_torques or scene.inputs.tip_force

    for name in ("exponent", "radius", "minimum_impact_speed"):
        d["contact"][name] = getattr(scene.contact, name)

    given = d["given"]
    given["law"] = _law_number(scene.contact.model)
    for name in ("stiffness", "restitution", "friction", "static_friction"):
        given[name] = getattr(scene.contact, name)

    initial = d["initial"]
    initial["position"], initial["velocity"] = scene.initial.position, scene.initial.velocity
    initial["angle"] = scene.initial.angles
    initial["angular_velocity"] = scene.initial.angular_velocities

    d["latest"]["kept"] = scene.outputs.impacts
    asked = scene.outputs
    d["impulse"]["wanted"] = asked.contacts or asked.impacts > 0 or (scene.has_friction and asked.energies)
    d["solver"]["method"] = SOLVER_METHODS.index(scene.solver.method) + 1
    for name in ("tolerance", "work_limit"):
        d["solver"][name] = getattr(scene.solver, name)
    _fill_walls(d, scene)
    if scene.stops.exponent is not None:
        _fill_stops(d, scene)
    _fill_given(d, scene)


def _fill_walls(d: Any, scene: Scene) -> None:
    """Put the walls at any angle, and the materials of all walls, in their places."""
    for name in ("restitution", "friction", "static_friction"):
        d["walls"][name] = -1.0  # that of `contact`
    if not scene.contact.points:  # the record has room for walls only where points may touch them
        return
    for w, wall in enumerate(scene.walls):
        for name, value in (("x", wall.point[0]), ("y", wall.point[1]), ("angle", wall.angle)):
            d["walls"][name][w] = value
    for w, wall_name in enumerate(scene.wall_names):
        material = scene.contact.wall.get(wall_name)
        for name in ("stiffness", "restitution", "friction", "static_friction"):
            if material and (value := getattr(material, name)) is not None:
                d["walls"][name][w] = value


def _fill_stops(d: Any, scene: Scene) -> None:
    """Put the stops in joints in their places."""
    stops, found = scene.stops, scene.chain.stops
    for joint, ends in scene.chain.joint_ranges.items():
        d["model"]["joint_min"][joint - 1], d["model"]["joint_max"][joint - 1] = ends
    d["candidate"]["stop"][-len(found) :] = [1 if stop == "joint_min" else -1 for _, stop in found]
    d["stops"]["law"] = _law_number(stops.model) if stops.model else 0
    for name in ("exponent", "restitution", "minimum_impact_speed"):
        d["stops"][name] = getattr(stops, name)
    d["given"]["stop_stiffness"] = stops.stiffness


def _fill_given(d: Any, scene: Scene) -> None:
    """Put what is given of the parameters that may be derived in its place; see kernel/model/derived.py."""
    derived = set(scene.derived_places)
    for i, link in enumerate(scene.chain.links):
        for name in ("center_of_mass", "inertia"):
            is_derived = ("chain", "links", i, name) in derived
            d["model"][f"given_{name}"][i] = DERIVED if is_derived else getattr(link, name)
    places = {"exponent": ("stops", "given_exponent"), "restitution": ("given", "stop_restitution")}
    for name, (part, field) in places.items():
        d[part][field] = DERIVED if ("stops", name) in derived else getattr(scene.stops, name) or 0.0


def _law_number(name: str) -> int:
    law = CONTACT_LAWS.get(name)
    return law.number if law else USER_LAW


def _with_tangents(block: np.ndarray, places: Sequence[Place]) -> np.ndarray:
    """An instance, and behind it those of dual numbers, each parameter of these places with a direction."""
    layout, count = block.dtype, -(-len(places) // DIRECTIONS)
    names = layout.names or ()
    behind = (BEHIND, tangent_dtype(layout), (count,))
    whole = np.zeros(1, np.dtype([*((name, layout[name]) for name in names), behind]))
    block["tangents"] = count
    for name in names:
        whole[name] = block[name]
    _copy_values(block[0], whole[0][BEHIND])
    for number, place in enumerate(places):
        field: Any = whole[0][BEHIND][number // DIRECTIONS]
        for step in place:
            field = field[step]
        field["slope"][number % DIRECTIONS] = 1.0
    return whole


def _copy_values(source: Any, target: np.ndarray) -> None:
    """Copy the values of a record to each of some records of dual numbers."""
    for name in source.dtype.names:
        part = target[name]
        if source.dtype[name].base.names:
            _copy_values(source[name], part)
        else:
            (part["value"] if part.dtype.names else part)[...] = source[name]
