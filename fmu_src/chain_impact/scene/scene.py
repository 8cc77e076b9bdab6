"""The scene: the content of a scene file, read from TOML into frozen dataclasses and checked.

The fields of the dataclasses in contents.py and keys/ define all keys of a scene. From the metadata of fields
follow validation, reference and FMU parameters. All values are in SI units, angles in radians.
"""

import functools
import operator
import os
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import Field, dataclass, replace
from html import escape
from pathlib import Path
from typing import Any, TypeAlias

from chain_impact.scene import complete_scene, shapes
from chain_impact.scene.checks import checks
from chain_impact.scene.contents import SceneContents
from chain_impact.scene.derived import (
    enclosing_paths,
    path_in_file,
    paths_in_scene,
    rule_at,
    rule_of,
    without_derived,
)
from chain_impact.scene.display import drawing, scene_text
from chain_impact.scene.errors import SceneError, value_text
from chain_impact.scene.facts import SceneFacts, friction_joints
from chain_impact.scene.fast_values import with_numbers
from chain_impact.scene.files.lines import fault_hint, line_of
from chain_impact.scene.files.models import scene_file_path, unreadable_message
from chain_impact.scene.files.text_file import text_of
from chain_impact.scene.plain_data import plain, without_empty
from chain_impact.scene.reading import Reader, keys_of, tell_all_faults
from chain_impact.scene.rules.key_rules import Derived
from chain_impact.scene.texts.names import DataPath, as_typed, name_of, path_text
from chain_impact.scene.value_paths import path_and_value, paths_by_name, single_values
from chain_impact.scene.warning import warn

SceneSource: TypeAlias = "Scene | str | os.PathLike[str]"
"""A scene, or an argument of ``load_scene``."""


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Scene(SceneContents):
    """All values that a simulation needs: the checked contents of a scene file.

    ``load_scene``, ``parse_scene`` and ``scene_from_dict`` return a scene.
    """

    @property
    def derived(self) -> dict[str, str]:
        """Name of a derived value → its rule in words, such as "length / 2".

        Values that the file does not give, but that follow from no other value, are left out.
        """
        rules, walls = dict(scene_keys()), [wall.name for wall in self.walls]
        rules_of_paths = ((path, self._rule(path, rules)) for path in self.derived_paths)
        return {name_of(path, walls): rule.text for path, rule in rules_of_paths if not rule.constant}

    def _rule(self, path: DataPath, rules: Mapping[str, Any]) -> Derived:
        return rule_at(rule_of(path, rules), path, self.chain.links)

    @property
    def values(self) -> dict[str, Any]:
        """Name → value, for each single value of the scene; ``with_values`` takes each of these names.

        The value is None where the scene has none, such as the position of a missing wall.
        """
        walls = [wall.name for wall in self.walls]
        return {name_of(path, walls): value for path, value in single_values(self)}

    @property
    def moving_walls(self) -> tuple[str, ...]:
        """The names of the existing walls in ``inputs.wall_motion``, in the order of ``wall_names``."""
        return tuple(wall["name"] for wall in SceneFacts(self)["moving_walls"])

    @property
    def has_contact_friction(self) -> bool:
        """Whether a point can touch a wall, and such a contact may have dry friction."""
        return bool(SceneFacts(self)["has_contact_friction"])

    @property
    def friction_joints(self) -> tuple[int, ...]:
        """The numbers of the existing joints whose ``joint_friction`` the file gives, even as 0."""
        return friction_joints(self)

    @property
    def is_driven(self) -> bool:
        """Whether energy may be supplied: by an input, or by a drive with a limit of its torque or force."""
        return bool(SceneFacts(self)["has_supply"])

    @property
    def has_friction(self) -> bool:
        """Whether a contact, a joint or a slider may have dry friction."""
        return bool(SceneFacts(self)["has_dry_friction"])

    def with_values(self, changes: Mapping[str, Any] | Mapping[tuple[Any, ...], Any]) -> "Scene":
        """Return the scene with some values changed, for example `{"contact.restitution": 0.5}`.

        The function `with_values` of this module has the details.
        """
        return with_values(self, changes)

    def __repr__(self) -> str:
        """Return the values of the scene that matter most, in a few lines of text."""
        return scene_text.scene_as_text(self)

    def _repr_html_(self) -> str:
        """Return HTML for a notebook: the text of ``repr``, and a small drawing of the chain at its start."""
        return f"<div>{drawing.scene_svg(self, self.values)}<pre>{escape(repr(self))}</pre></div>"


def scene_keys() -> Iterator[tuple[str, Field[Any]]]:
    """Yield every table and key of the scene file, such as `chain.links[].mass`, with its field."""
    return keys_of(Scene)


def load_scene(source: str | os.PathLike[str]) -> Scene:
    """Load a scene file, the scene file in a folder, or a model by its name; the first that exists is loaded.

    Probable mistakes in the scene give a SceneWarning each. Raises SceneError when there is no such file, or
    when the file cannot be read or is not a valid scene.
    """
    try:
        path = scene_file_path(source)
        text = text_of(path)
    except (OSError, TypeError, ValueError) as error:
        raise SceneError(unreadable_message(source, error)) from None
    scene = parse_scene(text, str(path))
    warn(str(path), checks.law_hints(scene))
    return scene


def scene_of(source: SceneSource) -> Scene:
    """Return ``source`` itself if it is a `Scene`, else the scene that `load_scene` reads from it."""
    return source if isinstance(source, Scene) else load_scene(source)


def parse_scene(text: str, source: str) -> Scene:
    """Return the scene of a TOML `text`; for `source` and warnings, see ``scene_from_dict``.

    Raises SceneError when the text is not valid TOML or not a valid scene.
    """
    try:
        data = tomllib.loads(text.removeprefix("\ufeff"))
    except (ValueError, RecursionError) as error:  # ValueError: wrong TOML, or too many digits
        raise SceneError(f"{source}: not valid TOML: {error}{fault_hint(text, str(error))}") from None
    try:
        return scene_from_dict(data, source)
    except SceneError as error:
        tell_all_faults(error, Scene, data, lambda path: line_of(text, path))
        raise


def scene_from_dict(data: Mapping[str, Any], source: str) -> Scene:
    """Return the checked scene; errors name the file `source`, in whose folder relative paths begin.

    Probable mistakes in the scene give a SceneWarning each. Raises SceneError when the data are not a valid
    scene.
    """
    scene = _validated_scene(data, source, in_file=True)
    warn(source, checks.scene_hints(scene))
    return scene


def _validated_scene(data: Mapping[str, Any], source: str, in_file: bool) -> Scene:
    """Return the checked scene from the data of a scene file, or raise a SceneError.

    If ``in_file`` is true, or an entry of the links has a count, the error has the path of the refused value
    in the file, such as "chain.links[1].mass"; else it has the name of the value, such as "link[1].mass".
    """
    walls = data.get("walls") if isinstance(data, Mapping) else None
    tables = walls if isinstance(walls, list | tuple) else []
    given_names = [table.get("name") if isinstance(table, Mapping) else None for table in tables]
    names = [name if isinstance(name, str) and name.isidentifier() else None for name in given_names]

    # if an entry of the links stands for several links, a name such as link[2].mass does not tell the entry
    by_path = in_file or _has_counts(data)

    def label(path: DataPath) -> str:
        return path_text(path) if by_path else name_of(shapes.scene_point_path(path, data), names)

    scene: Scene | None = None
    try:
        reader = Reader(Scene)
        scene = reader.read(data)
        scene = replace(scene, derived_paths=tuple(sorted(paths_in_scene(reader.derived, data))))
        scene = complete_scene.completed_scene(scene, Path(source).parent)
        checks.check_scene(scene)
    except SceneError as error:
        # an error of the reader has a path in the data; a later error has a path in the scene, in which an
        # entry with a count has become several links
        error.path = error.path if scene is None else path_in_file(error.path, data)
        if error.path[-1:] == ("model",):
            error.fault += complete_scene.misnamed_law_hint(data, error.value, Path(source).parent)
        error.name = label(error.path) if error.name and error.path else error.name
        error.source = source
        raise
    return scene


def _has_counts(data: Any) -> bool:
    """Return whether an entry of the links in the data of a file has the key ``count``."""
    chain = data.get("chain") if isinstance(data, Mapping) else None
    links = chain.get("links") if isinstance(chain, Mapping) else None
    tables = links if isinstance(links, list | tuple) else []
    return any(isinstance(table, Mapping) and "count" in table for table in tables)


def scene_to_dict(scene: Scene, *, derived: bool = False) -> dict[str, Any]:
    """Return the scene as plain dicts, lists and values that TOML can hold.

    Keys without a value are left out. If ``derived`` is true, the data also have the derived values, and the
    corners of boxes in place of ``shape`` and ``height``; a scene that is read from these data has all of
    them as given values.
    """
    data = plain(scene)
    if not derived:
        without_derived(data, scene.derived_paths)
    shapes.set_corners_apart(data, are_given=derived)
    return without_empty(shapes.without_corners(data))


def with_values(scene: SceneSource, changes: Mapping[str, Any] | Mapping[tuple[Any, ...], Any]) -> Scene:
    """Return the validated scene with some values changed; ``scene`` itself does not change.

    ``changes`` has names and new values: `{"link[1].mass": 2.0, "contact.model": "flores"}`. A name is the
    FMU's name of the parameter, or the dotted key of the file, which can also be the key of a whole list:
    `"initial.angles"`. A contact law and a solver method may be given by their number in the FMU, from 1. A
    path can replace a name: `("chain", "links", 0, "mass")`.

    The new value None removes the key, so that its default applies. All other given values stay, and derived
    values follow the given values, as after an edit of the scene file. Each probable mistake that the changes
    bring gives a SceneWarning.

    Raises SceneError when a name is unknown, a path leads nowhere, or the scene becomes invalid.
    """
    scene = scene_of(scene)
    warn(scene.name, checks.turning_hints(scene, changes))
    if (fast_scene := with_numbers(scene, changes)) is not None:
        return fast_scene
    # To make the table of all names takes longer than most changes: it is made once, and only if needed.
    names = functools.cache(lambda: paths_by_name(scene))
    values = [path_and_value(scene, names, *change) for change in changes.items()]
    try:
        changed_scene = _with_any(scene, values)
    except SceneError as error:
        error.name = as_typed(error.name, changes)
        raise
    hints_before = checks.scene_hints(scene)
    warn(scene.name, [hint for hint in checks.scene_hints(changed_scene) if hint not in hints_before])
    return changed_scene


def _with_any(scene: Scene, values: list[tuple[Any, Any]]) -> Scene:
    """Return the scene after changes, pairs (path, new value), with all data read and checked again."""
    data, paths = plain(scene), [path for path, _ in values]
    if JOINT_ANGLES_PATH in paths and complete_scene.ANGLES not in enclosing_paths(paths):
        del data["initial"]["angles"]
    # if one entry of a derived list is given, all entries of the list become given values
    without_derived(data, scene.derived_paths, kept_paths=enclosing_paths(paths))
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
    changed_scene = _validated_scene(without_empty(shapes.without_corners(data)), scene.name, in_file=False)
    keeps_angles = scene.has_joint_angles and complete_scene.ANGLES not in paths
    return replace(changed_scene, has_joint_angles=keeps_angles or changed_scene.has_joint_angles)


JOINT_ANGLES_PATH = ("initial", "joint_angles")  # this key may be given in place of ``initial.angles``


def fixed_hint(scene: Scene, name: str) -> str | None:
    """Return a hint how to change the value ``name`` of the scene, which cannot change during a run.

    The result is None if the scene has no such value, or if the value is None.
    """
    is_given = scene.values.get(name) is not None
    return "change it in the scene file, with --set or with_values" if is_given else None
