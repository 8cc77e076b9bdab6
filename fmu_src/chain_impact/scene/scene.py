"""The scene file: a chain, its box and how it starts, read from TOML into frozen dataclasses.

The dataclass fields are the one table of what a scene may hold. Unit, description, range and default stand
in each field's metadata, from which come the validation here, the scene reference in the docs and the
parameters of the FMU. All values are in SI units, angles in radians from +x.
"""

import functools
import operator
import os
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import Field, asdict, dataclass, fields, is_dataclass, replace
from numbers import Integral
from pathlib import Path
from typing import Any, TypeAlias

from chain_impact.kernel.integration.methods import SOLVER_METHODS
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.model.geometry import WALLS
from chain_impact.kernel.model.latest import LATEST
from chain_impact.scene import checks, scene_text
from chain_impact.scene.half_planes import HalfPlane, half_planes
from chain_impact.scene.limits import Derived, quantity
from chain_impact.scene.models import SCENE_FILE, model_names, scene_path
from chain_impact.scene.names import Place, name_of, parameter_hint, place_in_file
from chain_impact.scene.reading import Reader, SceneError, UnknownNameError, keys_of, shown
from chain_impact.scene.text_file import comma_in, text_of

SceneSource: TypeAlias = "Scene | str | os.PathLike[str]"
"""A scene, or what ``load_scene`` takes."""
MAX_LINKS = 1000

_IDENTIFIER = (r"[A-Za-z_][A-Za-z0-9_]*", "letters, digits and _, not beginning with a digit")
_XML_TEXT = (r"[^\x00-\x08\x0B\x0C\x0E-\x1F\uD800-\uDFFF\uFFFE\uFFFF]*", "text without control characters")
_NAME = (r"[A-Za-z][A-Za-z0-9_.*\[\]]*", "the name of a parameter or an input, with * for any text")
_PYTHON_FILE = (r"|[^\x00]*\.py", "the path of a Python file, from the folder of the scene")

_MIDDLE = Derived("length / 2", lambda link: link["length"] / 2)
_ROD = Derived("mass * length^2 / 12", lambda link: link["mass"] * link["length"] * link["length"] / 12)
_MOVABLE = Derived("all that move", lambda known: tuple(checks.movable_points(known["chain"])))
_ZEROS = Derived("zeros", lambda known: (0.0,) * len(known["chain"].links))


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """One rigid link, from its joint nearer to the base to the other one; in a file several."""

    count: int | None = quantity(
        "", "number of equal links, 1 if missing", None, minimum=1, maximum=MAX_LINKS, file_only=True
    )
    length: float = quantity("m", "length", above=0.0)
    mass: float = quantity("kg", "mass", above=0.0)
    center_of_mass: float = quantity(
        "m", "centre of mass, from the joint nearer to the base", _MIDDLE, minimum=0.0
    )
    inertia: float = quantity("kg.m2", "inertia about the centre of mass", _ROD, minimum=0.0)
    joint_damping: float = quantity(
        "N.m.s/rad", "viscous damping of the joint nearer to the base", 0.0, minimum=0.0
    )
    joint_stiffness: float = quantity(
        "N.m/rad", "stiffness of the joint nearer to the base", 0.0, minimum=0.0
    )
    joint_rest_angle: float = quantity("rad", "angle of the joint at which its spring is slack", 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """The links from base to tip, and whether the base moves."""

    base: str = quantity("", "base point: free to move, or pinned", "free", choices=("free", "pinned"))
    links: tuple[Link, ...] = quantity("", "links from base to tip", entries=(1, MAX_LINKS))

    def __post_init__(self) -> None:
        """Put each of the equal links of a `count` in the place of the one that has it."""
        if (total := sum(link.count or 1 for link in self.links)) > MAX_LINKS:
            raise SceneError(f"chain.links[].count makes {total} links in all, must make at most {MAX_LINKS}")
        links = (replace(link, count=None) for link in self.links for _ in range(link.count or 1))
        object.__setattr__(self, "links", tuple(links))


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """The walls along the axes; a missing key (None) is a missing wall."""

    x_min: float | None = quantity("m", "left wall", None)
    x_max: float | None = quantity("m", "right wall", None)
    y_min: float | None = quantity("m", "floor", None)
    y_max: float | None = quantity("m", "ceiling", None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wall:
    """A straight wall at any angle, without ends; in place of the angle a file may give a normal."""

    name: str = quantity("", "name, other than that of any other wall", matching=_IDENTIFIER)
    point: tuple[float, float] = quantity("m", "a point on the wall")
    angle: float | None = quantity("rad", "direction of the wall, from +x; its left is free", None)
    normal: tuple[float, float] | None = quantity("1", "in place of angle: a vector to the free side", None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """The force of the walls, and the points that may touch them."""

    law_file: str = quantity("", "file with a law of your own, named as the law", "", matching=_PYTHON_FILE)
    model: str = quantity("", "force law", "zhang_sharf", choices=tuple(CONTACT_LAWS), extended_by="law_file")
    stiffness: float = quantity("N/m^exponent", "contact stiffness", 1e8, above=0.0)
    exponent: float = quantity("1", "exponent of penetration, 3/2 for Hertz", 1.5, minimum=1.0, maximum=3.0)
    restitution: float = quantity("1", "prescribed restitution", 0.7, minimum=0.0, maximum=1.0)
    radius: float = quantity("m", "radius of every point that may touch", 0.0, minimum=0.0)
    points: tuple[int, ...] = quantity("", "points that may touch, base (0) to tip (N)", _MOVABLE)
    minimum_impact_speed: float = quantity(
        "m/s", "slower impacts are treated as having this speed", 1e-3, above=0.0
    )

    def __post_init__(self) -> None:
        """Sort the points: their order means nothing, so equal sets make equal scenes."""
        object.__setattr__(self, "points", tuple(sorted(self.points)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """The inputs that the FMU shall have."""

    joint_torques: bool = quantity("", "torques at the joints between links and at a pinned base", False)
    tip_force: bool = quantity("", "force on the tip", False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """The outputs that the FMU shall have, beside those of the last impact."""

    points: bool = quantity("", "position, velocity and acceleration of the points", True)
    links: bool = quantity("", "angle, its rate and acceleration of the links", True)
    contacts: bool = quantity("", "force, penetration and impulse of each contact", True)
    impacts: int = quantity("", "how many of the latest impacts", 8, minimum=0, maximum=LATEST)
    energies: bool = quantity("", "the energies", True)
    solver: bool = quantity("", "steps, evaluations and status of the solver", True)
    sensitivities: tuple[str, ...] = quantity(
        "", "parameters and inputs with respect to which outputs have derivatives", (), matching=_NAME
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Initial:
    """The state at time 0."""

    position: tuple[float, float] = quantity("m", "position of the base", (0.0, 0.0))
    angles: tuple[float, ...] = quantity("rad", "angle of each link, absolute, from +x", per_link=True)
    velocity: tuple[float, float] = quantity("m/s", "velocity of the base", (0.0, 0.0))
    angular_velocities: tuple[float, ...] = quantity(
        "rad/s", "angular velocity of each link, absolute", _ZEROS, per_link=True
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Solver:
    """How the equations of motion are integrated."""

    method: str = quantity("", "integration method", "auto", choices=SOLVER_METHODS)
    tolerance: float = quantity("1", "relative error tolerance", 1e-8, minimum=1e-13, maximum=1e-2)
    work_limit: float = quantity("1/s", "most evaluations of f for a second simulated", 5e6, above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """The default experiment."""

    stop_time: float = quantity("s", "end of the simulation", 1.0, above=0.0)
    step_size: float = quantity("s", "communication step", 1e-3, above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Scene:
    """All that a simulation needs. Made, and validated, by the functions of this module."""

    name: str = quantity("", "model name", matching=_IDENTIFIER)
    description: str = quantity("", "what the scene shows", "", matching=_XML_TEXT)
    gravity: tuple[float, float] = quantity("m/s2", "acceleration of gravity", (0.0, -9.81))
    chain: Chain
    box: Box
    walls: tuple[Wall, ...] = quantity("", "walls at any angle, beside the box or in place of it", ())
    contact: Contact
    inputs: Inputs
    initial: Initial
    outputs: Outputs
    solver: Solver
    simulation: Simulation

    @property
    def wall_names(self) -> tuple[str, ...]:
        """The names of the walls, in the order of their numbers: those of the box, then ``walls``."""
        return *WALLS, *(wall.name for wall in self.walls)

    @property
    def law_names(self) -> tuple[str, ...]:
        """The contact laws in the order of their numbers in the FMU, a law of one's own last."""
        file = self.contact.law_file
        return *CONTACT_LAWS, *([Path(file).stem] if file else [])

    @property
    def half_planes(self) -> dict[str, HalfPlane]:
        """The free sides of the walls that are there, by name."""
        box = {name: at for name in WALLS if (at := getattr(self.box, name)) is not None}
        return half_planes(box, {wall.name: (*wall.point, wall.angle or 0.0) for wall in self.walls})

    @property
    def values(self) -> dict[str, Any]:
        """Every single value by its name, as ``with_values`` takes it; None for what is not there."""
        walls = [wall.name for wall in self.walls]
        return {name_of(path, walls): value for path, value in _leaves(self)}

    def with_values(self, changes: Mapping[str, Any] | Mapping[Place, Any]) -> "Scene":
        """The scene with some values changed, `{"contact.restitution": 0.5}`; see the function."""
        return with_values(self, changes)

    def __repr__(self) -> str:
        """The scene in some lines."""
        return scene_text.text(self)


def scene_keys() -> Iterator[tuple[str, Field[Any]]]:
    """Yield every table and key of the scene file, `chain.links[].mass` for one, with its dataclass field."""
    return keys_of(Scene)


def load_scene(source: str | os.PathLike[str]) -> Scene:
    """Load a scene file, the scene file of a folder, or a model by its name, tried in this order.

    Raises SceneError when there is no such file, it cannot be read, or it does not hold a valid scene.
    """
    try:
        path = scene_path(source)
        text = text_of(path)
    except (OSError, TypeError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        wanted = f"a scene file, a folder with {SCENE_FILE}, or a model: {', '.join(model_names())}"
        raise SceneError(f"{source}: cannot be read ({reason}); must be {wanted}") from None
    return parse_scene(text, str(path))


def scene_of(source: SceneSource) -> Scene:
    """The scene itself, or the one that `load_scene` makes of its source."""
    return source if isinstance(source, Scene) else load_scene(source)


def parse_scene(text: str, source: str) -> Scene:
    """Return the scene that the TOML `text` describes; errors (SceneError) name it `source`."""
    try:
        data = tomllib.loads(text.removeprefix("\ufeff"))
    except (ValueError, RecursionError) as error:  # also Python's own limits on digits and nesting
        raise SceneError(f"{source}: not valid TOML: {error}{comma_in(text, str(error))}") from None
    return scene_from_dict(data, source)


def scene_from_dict(data: Mapping[str, Any], source: str) -> Scene:
    """Return the validated scene of a parsed scene file; errors (SceneError) name it `source`."""
    scene = _validated(data, source, in_file=True)
    checks.warn(source, checks.hints(scene))
    return scene


def _validated(data: Mapping[str, Any], source: str, in_file: bool) -> Scene:
    """Return the scene; in an error a key is called by its name and, of a file, by what stands there."""
    walls = data.get("walls") if isinstance(data, Mapping) else None
    tables = walls if isinstance(walls, list | tuple) else []
    given = [table.get("name") if isinstance(table, Mapping) else None for table in tables]
    names = [name if isinstance(name, str) and name.isidentifier() else None for name in given]
    counted = checks.has_counts(data)

    def label(path: Place) -> str:
        match path:
            case "chain", "links", int(i), key if counted:
                return f"{key} in entry {i + 1} of [[chain.links]]"
        name, written = name_of(path, names), place_in_file(path)
        return f"{name} ({written})" if in_file and written != name else name

    hints: list[str] = []
    try:
        scene: Scene = Reader(Scene, label).read(data)
        scene = checks.with_angles(checks.with_law_path(scene, Path(source).parent))
        hints = checks.angle_hints(scene)
        checks.check_together(scene)
        checks.check_start(scene)
    except SceneError as error:
        raise SceneError("; ".join([f"{source}: {error}", *hints])) from None
    return scene


def scene_to_dict(scene: Scene) -> dict[str, Any]:
    """Return the scene as plain dicts, lists and values that TOML can hold, without missing walls."""

    def plain(items: list[tuple[str, Any]]) -> dict[str, Any]:
        return {key: list(one) if isinstance(one, tuple) else one for key, one in items if one is not None}

    return asdict(scene, dict_factory=plain)


def with_values(scene: SceneSource, changes: Mapping[str, Any] | Mapping[Place, Any]) -> Scene:
    """Return the validated scene with some values changed.

    A change is a name and its value: `{"link[1].mass": 2.0, "contact.model": "flores"}`. The name is that of
    the FMU's parameter, else the dotted key, which also names a whole list: `"initial.angles"`. A contact law
    and a solver method can be given by their number in the FMU, too. A path can replace a name:
    `("chain", "links", 0, "mass")`.

    None removes the key, so that its default holds. All other values stay, also those that a default has
    derived from a value that changes.

    Raises SceneError when a name is unknown, a path leads nowhere, or the scene becomes invalid.
    """
    scene = scene_of(scene)
    values = [_place_and_value(scene, change, given) for change, given in changes.items()]
    if all(len(path) == 2 and path[1] in _INDEPENDENT.get(path[0], ()) for path, _ in values):  # noqa: PLR2004
        changed = _with_independent(scene, values)
    else:
        changed = _with_any(scene, values)
    known = checks.hints(scene)
    checks.warn(scene.name, [hint for hint in checks.hints(changed) if hint not in known])
    return changed


def _with_any(scene: Scene, values: list[tuple[Any, Any]]) -> Scene:
    """As with_values: all is read anew."""
    data: Any = scene_to_dict(scene)
    for path, value in values:
        try:
            *parents, last = path
            functools.reduce(operator.getitem, parents, data)[last] = value
        except (LookupError, TypeError, ValueError):
            raise SceneError(f"{scene.name}: {shown(path)} is no path to a value of the scene") from None
    return _validated(data, scene.name, in_file=False)


_INDEPENDENT: dict[Any, frozenset[str]] = {
    name: frozenset(entry.name for entry in fields(table))
    for name, table in (("inputs", Inputs), ("solver", Solver), ("simulation", Simulation))
}
"""The tables, and their keys, on which no other value of a scene depends."""


def _with_independent(scene: Scene, values: list[tuple[Any, Any]]) -> Scene:
    """As with_values, of independent tables only: to read all others anew takes ten times as long."""
    tables: dict[str, dict[str, Any]] = {}
    for (name, key), value in values:
        tables.setdefault(name, asdict(getattr(scene, name)))[key] = value
    try:
        for name, data in tables.items():
            table = type(getattr(scene, name))
            reader = Reader(table, lambda path: name_of((name, *path)))  # noqa: B023 - used in this round only
            scene = replace(scene, **{name: reader.read(data)})
    except SceneError as error:
        raise SceneError(f"{scene.name}: {error}") from None
    return scene


def _place_and_value(scene: Scene, change: str | Place, given: Any) -> tuple[Place, Any]:
    """The path of a change, which may be a name, and the value that it stands for."""
    if not isinstance(change, str):
        return change, given
    names = _keys() if change in _keys() else _keys() | _names(scene)
    if change not in names:
        raise UnknownNameError(
            scene.name, change, names, "no parameter", parameter_hint(change, len(scene.chain.links))
        )
    return names[change], _chosen(scene, change, given)


@functools.cache
def _keys() -> dict[str, Place]:
    """The path of every dotted key; of what is in a list of tables, of the list."""
    return {key: tuple(key.split(".")) for key, _ in scene_keys() if "[" not in key}


def _names(scene: Scene) -> dict[str, Place]:
    """The path of every single value by its name."""
    return {name: path for name, (path, _) in zip(scene.values, _leaves(scene), strict=True)}


def _leaves(value: Any, path: Place = (), unit: str = "") -> Iterator[tuple[Place, Any]]:
    """Yield the path of every single value, and the value; entries of a list of quantities are single."""
    if is_dataclass(value):
        for entry in (entry for entry in fields(value) if not entry.metadata.get("file_only")):
            inner = getattr(value, entry.name)
            yield from _leaves(inner, (*path, entry.name), entry.metadata.get("unit", ""))
    elif isinstance(value, tuple) and value and (unit or is_dataclass(value[0])):
        for i, one in enumerate(value):
            yield from _leaves(one, (*path, i))
    else:
        yield path, value


def _chosen(scene: Scene, name: str, value: Any) -> Any:
    """The value, but a choice for its number in the FMU, counted from 1."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        return value
    choices = {"contact.model": scene.law_names, "solver.method": SOLVER_METHODS}.get(name, ())
    return choices[int(value) - 1] if 0 < int(value) <= len(choices) else value
