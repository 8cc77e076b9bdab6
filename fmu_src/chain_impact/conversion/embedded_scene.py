"""A scene that is read from an MJCF file of this package: the scene in the file, with the user's changes.

Such a file has elements for MuJoCo, and beside them the data of the scene. Two conversions are compared: of
the elements in the file, and of the elements that this package writes for the scene. Where both give the same
value, the scene's value holds, because it is exact; so do values that MJCF cannot hold. Where the conversions
differ, a user has changed the elements, or has chosen other axes or joints: the value from the file's
elements holds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from chain_impact.conversion.differences import LINE_NAMES
from chain_impact.conversion.mjcf import read_mjcf_text
from chain_impact.conversion.mjcf_contacts import point_name
from chain_impact.conversion.mjcf_writing import mjcf_of
from chain_impact.conversion.planar import ConversionChoices, ConversionResult, planar_chain
from chain_impact.conversion.robot import identifier
from chain_impact.scene.scene import Scene, scene_from_dict, scene_to_dict
from chain_impact.scene.words.names import input_key
from chain_impact.text import names_text

# two numbers are the same, up to round-off, if they differ by at most SAME_NUMBER, or by this part of the
# larger one
SAME_NUMBER = 1e-12
ABSENT: Any = object()
"""The mark that stands for the value of a key that a table does not have."""
BODY = ("shape", "height", "points")
"""The keys of a link for its shape and its points."""


class EmbeddedScene(NamedTuple):
    """The scene in a file of this package, and the conversion of this scene to MJCF and back.

    Attributes:
        scene: the scene, from the data in the file.
        written: the conversion to a scene of the MJCF elements that this package writes for ``scene``.
    """

    scene: Scene
    written: ConversionResult


def read_embedded_scene(data: Mapping[str, Any], name: str, source: str) -> EmbeddedScene:
    """Return the scene of ``data`` with the name ``name``, and its conversion to MJCF and back.

    ``source`` is the file's name for messages.

    Raises:
        SceneError: when the data are not a valid scene.
        MissingExtraError: when mujoco is not installed.
    """
    scene = scene_from_dict({**data, "name": identifier(name, "model")}, source)
    return EmbeddedScene(scene, planar_chain(read_mjcf_text(mjcf_of(scene)[0]), ConversionChoices(), source))


def merge_embedded_scene(
    found: ConversionResult, embedded: EmbeddedScene, choices: ConversionChoices
) -> ConversionResult:
    """Return the conversion ``found`` of a file's elements, merged with the scene in the file.

    The docstring of this module tells which values hold. ``choices`` are the user's choices for ``found``.
    """
    scene, written = embedded
    merger = _Merger(scene, written.data, found.data, choices)
    data = merger.data()
    warnings, differs, left_out, notes = (
        [remark for remark in remarks if remark not in known]
        for remarks, known in zip(found[1:], written[1:], strict=True)
    )
    if merger.changed:
        text = names_text(list(dict.fromkeys(merger.changed)), LINE_NAMES)
        notes.append(f"values in which the file's elements differ from the scene in the file: {text}")
    if merger.lost:
        text = f"{', '.join(merger.lost)}: left out, as the file and the scene in it differ in axes or joints"
        warnings.append(text)
    if merger.missing:
        text = f"{', '.join(merger.missing)}: left out or shortened, as the file lacks their wall or motor"
        warnings.append(text)
    return ConversionResult(data, warnings, differs, left_out, notes)


class _Merger:
    """The merger of a scene with ``found``, the conversion of a file's elements.

    A value of the scene stays where ``found`` equals ``written``, the conversion of the elements that this
    package writes for the scene.

    Attributes:
        alike: whether both conversions have the same kind of base and the same number of links.
        turned: whether signals are left out: not ``alike``, or the user's choices change the start angles.
        numbers: name of the shape that stands for a point in MJCF → number of the point.
        changed: names of the values that come from the file's elements.
        lost: names of the tables and keys of the scene that are left out, because the file's axes or joints
            differ from those of the scene.
        missing: names of the inputs, signals and derivatives of the scene that are left out or shortened,
            because the file lacks their wall or motor.
    """

    def __init__(
        self, scene: Scene, written: Mapping[str, Any], found: Mapping[str, Any], choices: ConversionChoices
    ) -> None:
        self.scene, self.written, self.found = scene, written, found
        self.changed: list[str] = []
        self.lost: list[str] = []
        self.missing: list[str] = []
        one, other = written["chain"], found["chain"]
        self.alike = one["base"] == other["base"] and len(one["links"]) == len(other["links"])
        chosen = bool(choices.joints or choices.plane or choices.tip)
        angles = (data["initial"]["angles"] for data in (written, found))
        self.turned = not self.alike or (chosen and not _are_equal(*angles))
        count = len(scene.chain.links) + len(scene.chain.sites)
        self.numbers = {identifier(point_name(k), "geom"): k for k in range(count + 1)}

    def data(self) -> dict[str, Any]:
        """Return the data of the merged scene, and fill ``changed``, ``lost`` and ``missing``."""
        ours = scene_to_dict(self.scene)
        data: dict[str, Any] = self._merge_value("", *map(_mergeable_data, (ours, self.written, self.found)))
        if self.found["chain"]["base"] != "slider":
            data["chain"].pop("slider", None)
        data["walls"] = list(data["walls"].values())
        data["contact"] = self._contact(ours["contact"])
        data["chain"]["links"], touching = self._links(ours["chain"]["links"])
        if touching is not None:
            data["contact"]["points"] = touching
        if self.turned and data.pop("signals", None):
            self.lost.append("signals")
        if not self.alike and data["outputs"].pop("sensitivities", None):
            self.lost.append("outputs.sensitivities")
        self._leave_out_inputs(data)
        return data

    def _leave_out_inputs(self, data: dict[str, Any]) -> None:
        """Remove inputs, signals and derivatives from ``data`` whose wall or motor the file lacks.

        A signal keeps those of its inputs that exist; a signal without inputs is removed, and so are the
        derivatives with respect to its parameters.
        """
        inputs, walls = data["inputs"], {*data["box"], *(wall["name"] for wall in data["walls"])}
        gone = [name for name in inputs["wall_motion"] if name not in ("*", *walls)]
        inputs["wall_motion"] = [name for name in inputs["wall_motion"] if name not in gone]

        def exists(name: str) -> bool:
            key, wall = input_key(name), name.split(".")[1] if name.startswith("wall.") else ""
            is_there = key is None or bool(inputs.get(key))
            return is_there and (not wall or wall in walls)

        self.missing += [f"inputs.wall_motion {name}" for name in gone]
        signals = data.get("signals", {})
        for name, signal in list(signals.items()):
            driven, signal["input"] = signal["input"], list(filter(exists, signal["input"]))
            if signal["input"] != driven:
                self.missing.append(f"signals.{name}")
            if not signal["input"]:
                del signals[name]
        asked = data["outputs"].get("sensitivities", [])
        known = [name for name in asked if exists(name) and not self._is_of_lost_signal(name, signals)]
        if known != list(asked):
            data["outputs"]["sensitivities"] = known
            self.missing.append("outputs.sensitivities")

    def _is_of_lost_signal(self, name: str, signals: Mapping[str, Any]) -> bool:
        """Return whether ``name`` is a parameter of a signal that is in the scene, but not in ``signals``."""
        of, _, rest = name.partition(".")
        return of == "signal" and rest.partition(".")[0] in set(self.scene.signals) - set(signals)

    def _merge_value(self, key: str, ours: Any, written: Any, found: Any) -> Any:
        """Return the scene's value ``ours`` if ``written`` and ``found`` are the same, else ``found``.

        Tables, and three lists of equal length, are merged entry by entry. An entry of ``walls`` that is in
        ``written``, but not in ``found``, is left out: the result is then ABSENT. ``key`` is the name of the
        value for messages.
        """
        if key.startswith("walls.") and found is ABSENT and isinstance(written, dict):
            self.changed.append(key)
            return ABSENT
        if isinstance(found, dict) or isinstance(written, dict):
            tables = [table if isinstance(table, dict) else {} for table in (ours, written, found)]
            values = {
                name: self._merge_value(
                    f"{key}.{name}".strip("."), *(table.get(name, ABSENT) for table in tables)
                )
                for name in dict.fromkeys(name for table in tables for name in table)
            }
            return {name: value for name, value in values.items() if value is not ABSENT}
        lists = [value for value in (ours, written, found) if isinstance(value, list)]
        if len({len(value) for value in lists}) == 1 and len(lists) == 3:  # noqa: PLR2004
            numbered = isinstance(next(iter(found), None), dict)
            keys = [f"{key}[{n}]" if numbered else key for n in range(1, len(found) + 1)]
            return [self._merge_value(*parts) for parts in zip(keys, *lists, strict=True)]
        if _are_equal(written, found):
            return ours
        self.changed.append(key)
        return found

    def _contact(self, ours: dict[str, Any]) -> dict[str, Any]:
        """Return the table [contact] of the scene, ``ours``, with the changed coefficients of friction.

        A coefficient that the file's elements change is written to the wall's table in ``contact.wall``. The
        table of a wall that the file lacks is left out.
        """
        before, now = _frictions(self.written), _frictions(self.found)
        removed = before.keys() - now.keys()
        walls = {name: dict(table) for name, table in ours.get("wall", {}).items() if name not in removed}
        for name, friction in now.items():
            if not _are_equal(before.get(name), friction):
                self.changed.append(f"contact.wall.{name}.friction")
                walls.setdefault(name, {})["friction"] = friction
                # MJCF has only one coefficient of friction, which replaces both coefficients of the scene
                if "static_friction" in walls[name]:
                    walls[name]["static_friction"] = friction
        return {**ours, "wall": walls}

    def _links(self, ours: Sequence[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[int] | None]:
        """Return the tables of the links, and the numbers of the link ends (points 0 to N) that touch walls.

        The second result is None if the file's elements have the same lengths and points as those written for
        the scene: then ``contact.points`` of the scene holds. ``ours`` are the scene's tables of links.
        """
        written, found = (data["chain"]["links"] for data in (self.written, self.found))
        points = [link.get("points", []) for link in found]
        if self.alike:
            bare = [[_without_keys(link, BODY) for link in tables] for tables in (ours, written, found)]
            links: list[dict[str, Any]] = self._merge_value("link", *bare)
            same = [
                _are_equal([one["length"], one.get("points", [])], [other["length"], of])
                for one, other, of in zip(written, found, points, strict=True)
            ]
        else:
            self.changed.append("chain.links")
            links, same = [_without_keys(link, BODY) for link in found], [False] * len(found)
        touching = set[int]()
        for i, (link, tables) in enumerate(zip(links, points, strict=True)):
            own, ends = self._points(i, tables, link["length"])
            touching |= ends
            if same[i]:
                link |= {key: ours[i][key] for key in BODY if key in ours[i]}
            elif own or self.alike:
                link |= {"points": own}
                self.changed.append(f"link[{i + 1}].points")
        return links, None if all(same) else sorted(touching)

    def _points(
        self, i: int, tables: Sequence[dict[str, Any]], length: float
    ) -> tuple[list[dict[str, Any]], set[int]]:
        """Return the tables of the points of a link, and the numbers of the link's ends that touch walls.

        The ends of the link with index ``i`` are the points ``i`` and ``i`` + 1 of the chain.

        Args:
            i: the index of the link, from 0.
            tables: the link's points in the conversion of the file's elements.
            length: the length of the link [m].
        """
        points, ends = list[dict[str, Any]](), set[int]()
        first = len(self.scene.chain.links) + 1
        before = {
            self.numbers.get(table.get("name", ""), -1): table
            for link in self.written["chain"]["links"]
            for table in link.get("points", [])
        }
        for table in tables:
            number = self.numbers.get(table.get("name", ""), -1)
            if number not in before:
                points.append(table)
                continue
            known = before[number]
            place = [table["x"], table["y"]]
            at_end = [i + end for end in (0, 1) if _are_equal(place, [end * length, 0.0])]
            if number < first and at_end and _are_equal(table["radius"], known["radius"]):
                ends |= {*at_end}
            elif number < first:
                points.append(table | {"name": f"point_{number}"})
            else:
                points.append(self._keep_point(table, known, number - first))
        return points, ends

    def _keep_point(self, table: dict[str, Any], known: Mapping[str, Any], index: int) -> dict[str, Any]:
        """Return ``table`` with name and numbers of the scene's point; numbers changed in the file stay.

        Args:
            table: a point of the scene, in the conversion of the file's elements.
            known: the same point in the conversion of the elements that are written for the scene.
            index: index of the point in ``scene.chain.sites``.
        """
        site = self.scene.chain.sites[index][1]
        kept = {key: getattr(site, key) for key in ("x", "y", "radius") if _are_equal(table[key], known[key])}
        return {**table, **kept, "name": site.name}


def _mergeable_data(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data of a scene in the form of ``_merge_value``: ``walls`` is a table from name to wall.

    ``chain.links`` and ``contact`` are left out, because ``_links`` and ``_contact`` merge these tables.
    """
    walls = {wall["name"]: wall for wall in data.get("walls", [])}
    return {
        **_without_keys(data, ["contact"]),
        "chain": _without_keys(data["chain"], ["links"]),
        "walls": walls,
    }


def _frictions(data: Mapping[str, Any]) -> dict[str, float]:
    """Return name → coefficient of sliding friction, 0 if not given, for each wall in the data of a scene."""
    names = [*data.get("box", {}), *(wall["name"] for wall in data.get("walls", []))]
    materials = data.get("contact", {}).get("wall", {})
    return {name: materials.get(name, {}).get("friction", 0.0) for name in names}


def _without_keys(table: Mapping[str, Any], keys: Sequence[str]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key not in keys}


def _are_equal(one: Any, other: Any) -> bool:
    """Return whether two values are equal; numbers in them may differ by round-off (SAME_NUMBER)."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_are_equal(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_are_equal, one, other))
    if isinstance(one, float | int) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=SAME_NUMBER, abs_tol=SAME_NUMBER)
    return bool(one == other)
