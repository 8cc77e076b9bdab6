"""The structure of a scene, which determines its variables, their owners and the size of its record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import accumulate
from typing import Any

from chain_impact.kernel.record.counts import COUNTS, Counts
from chain_impact.kernel.rows.geometry import AT_WALL, STOP_CODES
from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import Scene
from chain_impact.scene.signals import Driven, driven_by
from chain_impact.scene.tables import Inputs, Outputs
from chain_impact.variables.owners import Owner, add_lists, known_of, owners_of


@dataclass(frozen=True)
class Structure:
    """All properties of a scene that determine which variables exist, without values of parameters.

    Scenes of one structure have the same outputs. Nothing may change ``known`` and ``lists``.

    Attributes:
        known: the facts and counts of the scene, and the lengths of its lists, by name: see owners.py.
        lists: the lists of the scene, see ``owners.LISTS``.
        signals: the driven inputs, one row for each.
    """

    known: Mapping[str, int]
    lists: Mapping[str, Sequence[Mapping[str, Any]]]
    signals: tuple[Driven, ...]

    def __hash__(self) -> int:
        """Return the hash of the facts and counts, which equal structures have in common."""
        return hash(tuple(self.known.values()))

    @cached_property
    def counts(self) -> Counts:
        """The counts at the start of the scene's record."""
        return Counts(*(self.known[name] for name in COUNTS))

    @property
    def driven_quantities(self) -> dict[str, tuple[int, int]]:
        """The quantities that signals drive: name → number of the signal, index in its ``outputs``."""
        positions: dict[str, tuple[int, int]] = {}
        for row, signal in enumerate(self.signals):
            positions |= {name: (row, order) for order, name in enumerate(signal.outputs) if name}
        return positions

    def owners(self, kind: str) -> list[Owner]:
        """Return the owners of a kind, a key of ``owners.OWNER_KINDS``, in the order of their variables."""
        return owners_of(kind, self.known, self.lists)


def structure_of(scene: Scene) -> Structure:
    """Return the structure of a scene."""
    pairs, signals = candidates(scene), driven_by(scene)
    stops = len(scene.chain.stops)
    at_walls = len(pairs) - stops - len(scene.slider_stops)
    lists: dict[str, Sequence[Mapping[str, Any]]] = {
        "sites": [
            {"link": i, "entry": j, "corner": j + 1 if j < link.corners else 0, "label": site.name}
            for i, link in enumerate(scene.chain.links)
            for j, site in enumerate(link.points)
        ],
        "candidates": _candidates(scene.wall_names, pairs, range(at_walls, at_walls + stops)),
        "walls": _walls(scene, pairs[:at_walls]),
        "lines": [{"name": wall.name} for wall in scene.walls],
        "laws": [{"name": name} for name in scene.law_names],
        "signals": [
            {"name": signal.signal, "input": signal.input, "knot_count": signal.knots} for signal in signals
        ],
        "steps": _steps(signals),
    }
    add_lists(lists, scene)
    flags = {**_flags("inputs", scene.inputs), **_flags("outputs", scene.outputs)}
    return Structure(known_of(flags, lists, scene), lists, signals)


def _flags(table: str, keys: Inputs | Outputs) -> dict[str, int]:
    """Return the values of a table by the names of their keys, such as ``inputs.tip_force``.

    A list of names counts as its length.
    """
    values = ((entry.name, getattr(keys, entry.name)) for entry in fields(keys))
    return {
        f"{table}.{name}": len(value) if isinstance(value, tuple) else int(value) for name, value in values
    }


def _candidates(
    walls: Sequence[str], pairs: Sequence[tuple[int, int]], at_joints: range
) -> list[dict[str, Any]]:
    """Return the list of the candidates; ``at_joints`` are the indices of the stops of joints."""
    found: list[dict[str, Any]] = []
    for c, (n, wall) in enumerate(pairs):
        stop = AT_WALL if c < at_joints.start else STOP_CODES[walls[wall]]
        named = {} if c in at_joints else {"name": walls[wall]}
        found.append({"n": n, "wall": wall, "stop": stop, "at_joint": c in at_joints, **named})
    return found


def _walls(scene: Scene, pairs: Sequence[tuple[int, int]]) -> list[dict[str, Any]]:
    """Return the list of the walls; ``pairs`` are the candidates that are no stops."""
    existing, touched = scene.half_planes, {wall for _, wall in pairs}
    return [
        {"name": name, "exists": name in existing, "touched": w in touched}
        for w, name in enumerate(scene.wall_names)
    ]


def _steps(signals: Sequence[Driven]) -> list[dict[str, Any]]:
    """Return the list of the steps of all driven inputs."""
    first = accumulate((signal.knots for signal in signals), initial=0)
    return [
        {"name": signal.signal, "input": signal.input, "entry": k, "knot": knot + k}
        for signal, knot in zip(signals, first, strict=False)
        if signal.is_steps
        for k in range(signal.knots)
    ]
