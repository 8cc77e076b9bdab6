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
from chain_impact.scene.texts.input_table import input_key
from chain_impact.text import names_text

# two numbers are the same, up to round-off, if they differ by at most SAME_NUMBER, or by this part of the
# larger one
SAME_NUMBER = 1e-12
NO_VALUE: Any = object()
"""The mark that stands for the value of a key that a table does not have."""
BODY = ("shape", "height", "points")
"""The keys of a link for its shape and its points."""


class EmbeddedScene(NamedTuple):
    """The scene in a file of this package, and the conversion of this scene to MJCF and back.

    Attributes:
        scene: the scene, from the data in the file.
        written_result: the conversion to a scene of the MJCF elements that this package writes for ``scene``.
    """

    scene: Scene
    written_result: ConversionResult


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
    robot_result: ConversionResult, embedded_scene: EmbeddedScene, choices: ConversionChoices
) -> ConversionResult:
    """Return the conversion ``robot_result`` of a file's elements, merged with the scene in the file.

    The docstring of this module tells which values hold. Remarks that the conversion to MJCF and back also
    has are left out. ``choices`` are the user's choices for ``robot_result``.
    """
    scene, written_result = embedded_scene
    merger = _Merger(scene, written_result.data, robot_result.data, choices)
    data = merger.data()
    warnings, differing_texts, left_out, notes = (
        [remark for remark in remarks if remark not in known_texts]
        for remarks, known_texts in zip(robot_result[1:], written_result[1:], strict=True)
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
    return ConversionResult(data, warnings, differing_texts, left_out, notes)


class _Merger:
    """The merger of a scene with ``found_data``, from the conversion of a file's elements.

    A value of the scene stays where ``found_data`` equals ``written_data``, from the
    conversion of the elements that this package writes for the scene.

    Attributes:
        is_alike: whether both conversions have the same kind of base and the same number of links.
        is_turned: whether signals are left out: not ``is_alike``, or the user's choices change the angles at
            the start.
        numbers: name of the shape that stands for a point in MJCF → number of the point.
        changed: names of the values that come from the file's elements.
        lost: names of the tables and keys of the scene that are left out, because the file's axes or joints
            differ from those of the scene.
        missing: names of the inputs, signals and derivatives of the scene that are left out or shortened,
            because the file lacks their wall or motor.
    """

    def __init__(
        self,
        scene: Scene,
        written_data: Mapping[str, Any],
        found_data: Mapping[str, Any],
        choices: ConversionChoices,
    ) -> None:
        self.scene, self.written_data, self.found_data = scene, written_data, found_data
        self.changed: list[str] = []
        self.lost: list[str] = []
        self.missing: list[str] = []
        written_chain, found_chain = written_data["chain"], found_data["chain"]
        self.is_alike = written_chain["base"] == found_chain["base"] and len(written_chain["links"]) == len(
            found_chain["links"]
        )
        has_choices = bool(choices.joints or choices.plane or choices.tip)
        angles = (data["initial"]["angles"] for data in (written_data, found_data))
        self.is_turned = not self.is_alike or (has_choices and not _are_equal(*angles))
        count = len(scene.chain.links) + len(scene.chain.sites)
        self.numbers = {identifier(point_name(k), "geom"): k for k in range(count + 1)}

    def data(self) -> dict[str, Any]:
        """Return the data of the merged scene, and fill ``changed``, ``lost`` and ``missing``."""
        own_data = scene_to_dict(self.scene)
        data: dict[str, Any] = self._merge_value(
            "", *map(_mergeable_data, (own_data, self.written_data, self.found_data))
        )
        if self.found_data["chain"]["base"] != "slider":
            data["chain"].pop("slider", None)
        data["walls"] = list(data["walls"].values())
        data["contact"] = self._contact(own_data["contact"])
        data["chain"]["links"], contact_points = self._links(own_data["chain"]["links"])
        if contact_points is not None:
            data["contact"]["points"] = contact_points
        if self.is_turned and data.pop("signals", None):
            self.lost.append("signals")
        if not self.is_alike and data["outputs"].pop("sensitivities", None):
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
            earlier_inputs, signal["input"] = signal["input"], list(filter(exists, signal["input"]))
            if signal["input"] != earlier_inputs:
                self.missing.append(f"signals.{name}")
            if not signal["input"]:
                del signals[name]
        asked_names = data["outputs"].get("sensitivities", [])
        known_names = [
            name for name in asked_names if exists(name) and not self._is_of_lost_signal(name, signals)
        ]
        if known_names != list(asked_names):
            data["outputs"]["sensitivities"] = known_names
            self.missing.append("outputs.sensitivities")

    def _is_of_lost_signal(self, name: str, signals: Mapping[str, Any]) -> bool:
        """Return whether ``name`` is a parameter of a signal that is in the scene, but not in ``signals``."""
        owner, _, name_rest = name.partition(".")
        return owner == "signal" and name_rest.partition(".")[0] in set(self.scene.signals) - set(signals)

    def _merge_value(self, key: str, own_value: Any, written_value: Any, found_value: Any) -> Any:
        """Return the scene's ``own_value`` if ``written_value`` equals ``found_value``, else ``found_value``.

        Tables, and three lists of equal length, are merged entry by entry. An entry of ``walls`` that is in
        ``written_value``, but not in ``found_value``, is left out: the result is then NO_VALUE. ``key`` is
        the name of the value for messages.
        """
        if key.startswith("walls.") and found_value is NO_VALUE and isinstance(written_value, dict):
            self.changed.append(key)
            return NO_VALUE
        if isinstance(found_value, dict) or isinstance(written_value, dict):
            tables = [
                table if isinstance(table, dict) else {} for table in (own_value, written_value, found_value)
            ]
            values = {
                name: self._merge_value(
                    f"{key}.{name}".strip("."), *(table.get(name, NO_VALUE) for table in tables)
                )
                for name in dict.fromkeys(name for table in tables for name in table)
            }
            return {name: value for name, value in values.items() if value is not NO_VALUE}
        lists = [value for value in (own_value, written_value, found_value) if isinstance(value, list)]
        if len({len(value) for value in lists}) == 1 and len(lists) == 3:  # noqa: PLR2004
            has_numbers = isinstance(next(iter(found_value), None), dict)
            keys = [f"{key}[{n}]" if has_numbers else key for n in range(1, len(found_value) + 1)]
            return [self._merge_value(*parts) for parts in zip(keys, *lists, strict=True)]
        if _are_equal(written_value, found_value):
            return own_value
        self.changed.append(key)
        return found_value

    def _contact(self, own_data: dict[str, Any]) -> dict[str, Any]:
        """Return the table [contact] of the scene, ``own_data``, with the changed coefficients of friction.

        A coefficient that the file's elements change is written to the wall's table in ``contact.wall``. The
        table of a wall that the file lacks is left out.
        """
        written_frictions, found_frictions = _frictions(self.written_data), _frictions(self.found_data)
        removed_names = written_frictions.keys() - found_frictions.keys()
        walls = {
            name: dict(table) for name, table in own_data.get("wall", {}).items() if name not in removed_names
        }
        for name, friction in found_frictions.items():
            if not _are_equal(written_frictions.get(name), friction):
                self.changed.append(f"contact.wall.{name}.friction")
                walls.setdefault(name, {})["friction"] = friction
                # MJCF has only one coefficient of friction, which replaces both coefficients of the scene
                if "static_friction" in walls[name]:
                    walls[name]["static_friction"] = friction
        return {**own_data, "wall": walls}

    def _links(self, own_links: Sequence[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[int] | None]:
        """Return the tables of the links, and the numbers of the link ends (points 0 to N) that touch walls.

        The second result is None if the file's elements have the same lengths and points as those written for
        the scene: then ``contact.points`` of the scene holds. ``own_links`` are the scene's tables of links.
        """
        written_links, found_links = (data["chain"]["links"] for data in (self.written_data, self.found_data))
        points = [link.get("points", []) for link in found_links]
        if self.is_alike:
            links_without_points = [
                [_without_keys(link, BODY) for link in tables]
                for tables in (own_links, written_links, found_links)
            ]
            links: list[dict[str, Any]] = self._merge_value("link", *links_without_points)
            same = [
                _are_equal(
                    [written_link["length"], written_link.get("points", [])],
                    [found_link["length"], point_tables],
                )
                for written_link, found_link, point_tables in zip(
                    written_links, found_links, points, strict=True
                )
            ]
        else:
            self.changed.append("chain.links")
            links, same = [_without_keys(link, BODY) for link in found_links], [False] * len(found_links)
        contact_points = set[int]()
        for i, (link, tables) in enumerate(zip(links, points, strict=True)):
            own_points, ends = self._points(i, tables, link["length"])
            contact_points |= ends
            if same[i]:
                link |= {key: own_links[i][key] for key in BODY if key in own_links[i]}
            elif own_points or self.is_alike:
                link |= {"points": own_points}
                self.changed.append(f"link[{i + 1}].points")
        return links, None if all(same) else sorted(contact_points)

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
        points_before = {
            self.numbers.get(table.get("name", ""), -1): table
            for link in self.written_data["chain"]["links"]
            for table in link.get("points", [])
        }
        for table in tables:
            number = self.numbers.get(table.get("name", ""), -1)
            if number not in points_before:
                points.append(table)
                continue
            known_point = points_before[number]
            position = [table["x"], table["y"]]
            at_end = [i + end for end in (0, 1) if _are_equal(position, [end * length, 0.0])]
            if number < first and at_end and _are_equal(table["radius"], known_point["radius"]):
                ends |= {*at_end}
            elif number < first:
                points.append(table | {"name": f"point_{number}"})
            else:
                points.append(self._keep_point(table, known_point, number - first))
        return points, ends

    def _keep_point(
        self, table: dict[str, Any], known_point: Mapping[str, Any], index: int
    ) -> dict[str, Any]:
        """Return ``table`` with name and numbers of the scene's point; numbers changed in the file stay.

        Args:
            table: a point of the scene, in the conversion of the file's elements.
            known_point: the same point in the conversion of the elements that are written for the scene.
            index: index of the point in ``scene.chain.sites``.
        """
        site = self.scene.chain.sites[index][1]
        kept_values = {
            key: getattr(site, key)
            for key in ("x", "y", "radius")
            if _are_equal(table[key], known_point[key])
        }
        return {**table, **kept_values, "name": site.name}


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


def _are_equal(first_value: Any, second_value: Any) -> bool:
    """Return whether two values are equal; numbers in them may differ by round-off (SAME_NUMBER)."""
    if isinstance(first_value, dict) and isinstance(second_value, dict):
        return first_value.keys() == second_value.keys() and all(
            _are_equal(first_value[key], second_value[key]) for key in first_value
        )
    if isinstance(first_value, list) and isinstance(second_value, list):
        return len(first_value) == len(second_value) and all(map(_are_equal, first_value, second_value))
    if isinstance(first_value, float | int) and isinstance(second_value, float | int):
        return math.isclose(first_value, second_value, rel_tol=SAME_NUMBER, abs_tol=SAME_NUMBER)
    return bool(first_value == second_value)
