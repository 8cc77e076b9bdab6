"""The scene file: a chain, its box and its start, read from TOML into frozen dataclasses.

The fields of the dataclasses in contents.py, tables.py, chain_tables.py and signal.py define all keys of a
scene. The metadata of a field have unit, description, range and default; the validation, the scene reference
in the docs and the parameters of the FMU follow from these metadata. All values are in SI units, angles in
radians.
"""

import functools
import operator
import os
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import Field, dataclass, is_dataclass, replace
from html import escape
from numbers import Integral
from pathlib import Path
from typing import Any, TypeAlias

from chain_impact.kernel.ode.control import SOLVER_METHODS
from chain_impact.scene import checks, completion, drawing, scene_text, shapes
from chain_impact.scene.chain_tables import Link
from chain_impact.scene.contents import Contents, named_point_hint, slider_hint
from chain_impact.scene.derived import above, path_in_file, paths_in_scene, rule_at, rule_of, without_derived
from chain_impact.scene.facts import SceneFacts, friction_joints
from chain_impact.scene.fast_values import with_numbers
from chain_impact.scene.key_rules import Derived, keys
from chain_impact.scene.lines import fault_hint, line_of
from chain_impact.scene.models import scene_path, unreadable
from chain_impact.scene.names import (
    DataPath,
    fmu_name,
    name_of,
    other_names,
    parameter_hint,
    path_text,
)
from chain_impact.scene.reading import Reader, SceneError, UnknownNameError, as_typed, keys_of, value_text
from chain_impact.scene.text_file import text_of
from chain_impact.scene.warning import warn

SceneSource: TypeAlias = "Scene | str | os.PathLike[str]"
"""A scene, or an argument of ``load_scene``."""


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Scene(Contents):
    """All values that a simulation needs: the checked contents of a scene file.

    ``load_scene``, ``parse_scene`` and ``scene_from_dict`` return a scene.
    """

    @property
    def derived(self) -> dict[str, str]:
        """The derived values, as a table from the name of a value to its rule, such as "length / 2".

        A derived value whose rule always gives the same number is left out.
        """
        rules, walls = dict(scene_keys()), [wall.name for wall in self.walls]
        rules_of_paths = ((path, self._rule(path, rules)) for path in self.derived_paths)
        return {name_of(path, walls): rule.text for path, rule in rules_of_paths if not rule.constant}

    def _rule(self, path: DataPath, rules: Mapping[str, Any]) -> Derived:
        return rule_at(rule_of(path, rules), path, self.chain.links)

    @property
    def values(self) -> dict[str, Any]:
        """Name → value for each single value of the scene; ``with_values`` takes each of these names.

        A value is None if the scene does not have it, such as the position of a missing wall.
        """
        walls = [wall.name for wall in self.walls]
        return {name_of(path, walls): value for path, value in _leaves(self)}

    @property
    def moving_walls(self) -> tuple[str, ...]:
        """The names of the walls that inputs move (``inputs.wall_motion``), in the order of their numbers."""
        return tuple(wall["name"] for wall in SceneFacts(self)["moving_walls"])

    @property
    def has_contact_friction(self) -> bool:
        """Whether a point can touch a wall, and such a contact may have dry friction."""
        return bool(SceneFacts(self)["contact_friction"])

    @property
    def friction_joints(self) -> tuple[int, ...]:
        """The numbers of the joints that may have dry friction."""
        return friction_joints(self)

    @property
    def is_driven(self) -> bool:
        """Whether something may supply energy: an input, or a drive with a limited torque or force."""
        return bool(SceneFacts(self)["supply"])

    @property
    def has_friction(self) -> bool:
        """Whether a contact, a joint or a slider may have dry friction."""
        return bool(SceneFacts(self)["friction"])

    def with_values(self, changes: Mapping[str, Any] | Mapping[tuple[Any, ...], Any]) -> "Scene":
        """Return the scene with some values changed, for example `{"contact.restitution": 0.5}`.

        The function `with_values` of this module has the details.
        """
        return with_values(self, changes)

    def __repr__(self) -> str:
        """Return a description of the scene in a few lines of text."""
        return scene_text.text(self)

    def _repr_html_(self) -> str:
        """Return the description for a notebook, with a small drawing of the chain in its initial state."""
        return f"<div>{drawing.svg(self, self.values)}<pre>{escape(repr(self))}</pre></div>"


def scene_keys() -> Iterator[tuple[str, Field[Any]]]:
    """Yield every table and key of the scene file, such as `chain.links[].mass`, with its field."""
    return keys_of(Scene)


def load_scene(source: str | os.PathLike[str]) -> Scene:
    """Load a scene file, the scene file in a folder, or a model by its name; the first that exists is loaded.

    Raises SceneError when there is no such file, or when the file cannot be read or is not a valid scene.
    """
    try:
        path = scene_path(source)
        text = text_of(path)
    except (OSError, TypeError, ValueError) as error:
        raise SceneError(unreadable(source, error)) from None
    scene = parse_scene(text, str(path))
    warn(str(path), checks.law_hints(scene))
    return scene


def scene_of(source: SceneSource) -> Scene:
    """Return ``source`` itself if it is a scene, else the scene that `load_scene` reads."""
    return source if isinstance(source, Scene) else load_scene(source)


def parse_scene(text: str, source: str) -> Scene:
    """Return the scene that the TOML `text` describes; a SceneError names the text as `source`."""
    try:
        data = tomllib.loads(text.removeprefix("\ufeff"))
    except (ValueError, RecursionError) as error:  # ValueError includes Python's own limits on digits
        raise SceneError(f"{source}: not valid TOML: {error}{fault_hint(text, str(error))}") from None
    try:
        return scene_from_dict(data, source)
    except SceneError as error:
        line = line_of(text, error.path)
        if line is None:
            raise
        raise SceneError(f"{error} (at line {line})", error.path) from None


def scene_from_dict(data: Mapping[str, Any], source: str) -> Scene:
    """Return the checked scene from the data of a scene file; a SceneError names the data as `source`."""
    scene = _validated(data, source, in_file=True)
    warn(source, checks.hints(scene))
    return scene


def _validated(data: Mapping[str, Any], source: str, in_file: bool) -> Scene:
    """Return the checked scene from the data of a scene file.

    An error names the refused value by its path in the file if ``in_file`` is true or links have counts, else
    by its name, such as ``link[1].mass``.
    """
    walls = data.get("walls") if isinstance(data, Mapping) else None
    tables = walls if isinstance(walls, list | tuple) else []
    given = [table.get("name") if isinstance(table, Mapping) else None for table in tables]
    names = [name if isinstance(name, str) and name.isidentifier() else None for name in given]

    # if an entry of the links stands for several links, names such as link[2].mass would not tell the entry
    by_path = in_file or _has_counts(data)

    def label(path: DataPath) -> str:
        return path_text(path) if by_path else name_of(shapes.among_all_points(path, data), names)

    scene: Scene | None = None
    try:
        reader = Reader(Scene, label)
        scene = reader.read(data)
        scene = replace(scene, derived_paths=tuple(sorted(paths_in_scene(reader.derived, data))))
        scene = completion.completed(scene, Path(source).parent)
        checks.check(scene)
    except SceneError as error:
        # an error of the reader has a path in the data; a later error has a path in the scene, where an entry
        # with a count has become several links
        text, path = str(error), error.path if scene is None else path_in_file(error.path, data)
        if error.path and text.startswith(written := path_text(error.path)):
            text = label(path) + text.removeprefix(written)
        raise SceneError(f"{source}: {text}", path) from None
    return scene


def _has_counts(data: Any) -> bool:
    """Return whether an entry of the links in the data of a file has the key ``count``."""
    chain = data.get("chain") if isinstance(data, Mapping) else None
    links = chain.get("links") if isinstance(chain, Mapping) else None
    tables = links if isinstance(links, list | tuple) else []
    return any(isinstance(table, Mapping) and "count" in table for table in tables)


def _paths_by_name(scene: Scene) -> dict[str, DataPath]:
    """Return name → path of tables, keys and values: `chain.links`, `initial.angles`, `link[1].mass`."""
    return _keys() | _names(scene)


def scene_to_dict(scene: Scene, *, derived: bool = False) -> dict[str, Any]:
    """Return the scene as plain dicts, lists and values that TOML can hold.

    Keys without a value are left out. With ``derived`` the data also contain the derived values, and the
    corners of boxes in place of ``shape`` and ``height``; in a scene read from these data, they are given.
    """
    data = _plain(scene)
    if not derived:
        without_derived(data, scene.derived_paths)
    shapes.set_corners_apart(data, given=derived)
    return _without_empty(shapes.without_corners(data))


def _plain(value: Any) -> Any:
    """Return a value as plain dicts, lists and values.

    Keys without a value are left out, empty tables are not. dataclasses.asdict is slower, because it copies
    each number.
    """
    if is_dataclass(value):
        parts = ((entry.name, getattr(value, entry.name)) for entry in keys(value.__class__))
        return {name: _plain(part) for name, part in parts if part is not None}
    if isinstance(value, Mapping):
        return {name: _plain(part) for name, part in value.items()}
    return [_plain(part) for part in value] if isinstance(value, tuple) else value


def _without_empty(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data of a scene without [stops], [signals], materials and lists of points that are empty."""
    data, contact, chain = dict(data), data["contact"], data["chain"]
    if isinstance(chain, Mapping) and isinstance(chain.get("links"), list):
        data["chain"] = {**chain, "links": [_without_no_points(link) for link in chain["links"]]}
    for table in ("stops", "signals"):
        if isinstance(data.get(table), Mapping) and not data[table]:
            del data[table]
    if isinstance(contact, Mapping) and isinstance(contact.get("wall"), Mapping):
        walls = {name: table for name, table in contact["wall"].items() if _holds(table)}
        data["contact"] = {key: value for key, value in contact.items() if key != "wall"}
        data["contact"] |= {"wall": walls} if walls else {}
    return data


def _without_no_points(link: Any) -> Any:
    """Return the data of a link; leave out the list of points if it is empty."""
    empty = isinstance(link, Mapping) and isinstance(link.get("points"), list) and not link["points"]
    return {key: value for key, value in link.items() if key != "points"} if empty else link


def _holds(table: Any) -> bool:
    """Return False for a table that is empty or has only None, True for any other table or object.

    A table inside the table counts as a value, whatever it contains.
    """
    return not isinstance(table, Mapping) or any(value is not None for value in table.values())


def with_values(scene: SceneSource, changes: Mapping[str, Any] | Mapping[tuple[Any, ...], Any]) -> Scene:
    """Return the validated scene with some values changed.

    ``changes`` has names and new values: `{"link[1].mass": 2.0, "contact.model": "flores"}`. A name is the
    FMU's name of the parameter, or the dotted key of the file, which can also be the key of a whole list:
    `"initial.angles"`. A contact law and a solver method may be given by their number in the FMU. A path can
    replace a name: `("chain", "links", 0, "mass")`.

    None removes the key, so that the default applies. All other given values stay, and derived values follow
    the given values, as after an edit of the scene file.

    Raises SceneError when a name is unknown, a path leads nowhere, or the scene becomes invalid.
    """
    scene = scene_of(scene)
    warn(scene.name, checks.turning_hints(scene, changes))
    if (quick := with_numbers(scene, changes)) is not None:
        return quick
    with as_typed(changes):
        # The table of all names takes longer to make than most changes: it is made once, and only if needed.
        names = functools.cache(lambda: _paths_by_name(scene))
        changed = _with_any(scene, [_path_and_value(scene, names, *change) for change in changes.items()])
    hints_before = checks.hints(scene)
    warn(scene.name, [hint for hint in checks.hints(changed) if hint not in hints_before])
    return changed


def _with_any(scene: Scene, values: list[tuple[Any, Any]]) -> Scene:
    """Return the scene with any values changed, by reading and checking all data of the scene again."""
    data, paths = _plain(scene), [path for path, _ in values]
    if JOINT_ANGLES_PATH in paths and completion.ANGLES not in above(paths):
        del data["initial"]["angles"]
    # if one entry of a derived list is given, all entries of the list become given values
    without_derived(data, scene.derived_paths, kept=above(paths))
    shapes.set_corners_apart(data)
    for path, value in values:
        shapes.refuse_corner(scene, path)
        try:
            *parents, last = path
            functools.reduce(operator.getitem, parents, data)[last] = value
        except (LookupError, TypeError, ValueError):
            raise SceneError(
                f"{scene.name}: {value_text(path)} is not a path to a value of the scene"
            ) from None
    changed = _validated(_without_empty(shapes.without_corners(data)), scene.name, in_file=False)
    kept = scene.has_joint_angles and completion.ANGLES not in paths
    return replace(changed, has_joint_angles=kept or changed.has_joint_angles)


JOINT_ANGLES_PATH = ("initial", "joint_angles")
"""The path of the key for joint angles, which a file may have in place of ``initial.angles``."""


def _path_and_value(
    scene: Scene, every: Callable[[], dict[str, DataPath]], change: str | DataPath, given: Any
) -> tuple[DataPath, Any]:
    """Return the path and the value of a change that names its value by path or by name.

    Refuse an unknown name. ``every`` is a function that returns the table from name to path for all names of
    the scene; it is called only if needed.
    """
    given = given.tolist() if hasattr(given, "tolist") else given
    if not isinstance(change, str):
        return change, given
    names = _keys() if change in _keys() else every()
    written = (change, *other_names(change))
    typed, change = change, next((name for name in written if name in names), fmu_name(change))
    if (hint := slider_hint(scene, change)) or change not in names:
        hint = hint or parameter_hint(change, len(scene.chain.links), scene.signals)
        hint = hint or named_point_hint(scene, change, names)
        raise UnknownNameError(scene.name, typed, names, "not a parameter", hint)
    return names[change], _chosen(scene, change, given)


def fixed_hint(scene: Scene, name: str) -> str | None:
    """Return a hint how to change the value ``name``, which cannot change in a run.

    The result is None if the scene has no value of this name.
    """
    there = scene.values.get(name) is not None
    return "change it in the scene file, with --set or with_values" if there else None


@functools.cache
def _keys() -> dict[str, DataPath]:
    """Return a table from dotted key to path, for keys that are not in lists of tables or in named tables.

    A named table is one to which the user gives a name, such as a signal.
    """
    return {key: tuple(key.split(".")) for key, _ in scene_keys() if not set("[<") & set(key)}


def _names(scene: Scene) -> dict[str, DataPath]:
    """Return a table from name to path, for every single value of the scene."""
    walls = [wall.name for wall in scene.walls]
    return {name_of(path, walls): path for path, _ in _leaves(scene)}


def _leaves(
    value: Any, path: DataPath = (), unit: str = "", apart: int = 0
) -> Iterator[tuple[DataPath, Any]]:
    """Yield the path and the value of every single value.

    In a list of numbers with a ``unit``, each entry is a single value; in a list of tables, each value of a
    table is one. Any other list is a single value as a whole. The first ``apart`` entries of a list ``value``
    are left out: these are corners, which follow from the size of a box.
    """
    if is_dataclass(value):
        for entry in (entry for entry in keys(value.__class__) if not entry.metadata.get("file_only")):
            inner, unit = getattr(value, entry.name), entry.metadata.get("unit", "")
            apart = value.corners if entry.name == "points" and isinstance(value, Link) else 0
            yield from _leaves(inner, (*path, entry.name), unit, apart)
    elif isinstance(value, Mapping):
        for name, child in value.items():
            yield from _leaves(child, (*path, name))
    elif isinstance(value, tuple) and value[apart:] and (unit or is_dataclass(value[0])):
        for i, child in enumerate(value[apart:], apart):
            yield from _leaves(child, (*path, i))
    else:
        yield path, value[apart:] if apart else value


def _chosen(scene: Scene, name: str, value: Any) -> Any:
    """Return ``value``; for an integer, return the choice with this number in the FMU, counted from 1.

    Only a contact law and the solver's method have numbers; any other ``value`` is returned unchanged.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        return value
    laws = dict.fromkeys(("contact.model", "stops.model"), scene.law_names)
    choices = {**laws, "solver.method": SOLVER_METHODS}.get(name, ())
    return choices[int(value) - 1] if 0 < int(value) <= len(choices) else value
