"""Derived values of a scene: defaults that follow from other values.

A value that the user does not give is derived, and follows changes of the other values. Only given values are
written to files. ``Scene.derived_paths`` has the paths of the derived values. The kernel derives parameters
of a record in the same way: kernel/chain/inertia.py.
"""

from __future__ import annotations

import functools
import operator
from bisect import bisect_right
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from itertools import accumulate, pairwise
from typing import Any

from chain_impact.scene.rules.key_rules import Derived
from chain_impact.scene.texts.names import DataPath


def paths_in_scene(paths: Iterable[DataPath], data: Mapping[str, Any]) -> Iterator[DataPath]:
    """Yield the paths in the scene of the values that have the ``paths`` in ``data``, the data of a file.

    In the file, an entry of links with a count stands for several links; in the scene, each link has an
    entry. So the path of a key of such an entry gives a path for each of these links. A path into a list or
    table of a link is not changed.
    """
    counts = [entry.get("count") or 1 for entry in data["chain"]["links"]]
    links = [range(*ends) for ends in pairwise(accumulate(counts, initial=0))]
    for path in paths:
        match path:
            case "chain", "links", int(entry), str(key):
                yield from (("chain", "links", i, key) for i in links[entry])
            case _:
                yield path


def path_in_file(path: DataPath, data: Mapping[str, Any]) -> DataPath:
    """Return the path in ``data``, the data of a file, of the value with the ``path`` in the scene.

    In the file, an entry of links with a count stands for several links; in the scene, each link has an
    entry.
    """
    match path:
        case "chain", "links", int(i), *following:
            counts = [entry.get("count") or 1 for entry in data["chain"]["links"]]
            return ("chain", "links", bisect_right([*accumulate(counts)], i), *following)
    return path


def without_derived(data: Any, derived: Iterable[DataPath], kept_paths: Container[DataPath] = ()) -> None:
    """Remove the values at the paths ``derived``, except ``kept_paths``, from plain ``data`` of a scene."""
    # long paths come first: a derived table is removed after the derived values in it
    for path in sorted(derived, key=len, reverse=True):
        if path not in kept_paths:
            *parents, key = path
            del functools.reduce(operator.getitem, parents, data)[key]


def enclosing_paths(paths: Iterable[Any]) -> set[DataPath]:
    """Return the paths of all tables and lists that contain a value at ``paths``, without the whole data.

    An entry of ``paths`` that is no path, such as the name of a value, is ignored.
    """
    proper = [
        path
        for path in paths
        if isinstance(path, tuple) and all(isinstance(step, str | int) for step in path)
    ]
    return {path[:k] for path in proper for k in range(1, len(path))}


def rule_at(rule: Derived, path: DataPath, links: Sequence[Any]) -> Derived:
    """Return the rule that derives the value at ``path``, whose key has the default ``rule``.

    The result is ``rule.of_box`` if there is one and ``path`` leads to a key of a link that is a box; else
    ``rule``.
    """
    match path:
        case "chain", "links", int(i), _ if rule.of_box and links[i].shape:
            return rule.of_box
    return rule


def rule_of(path: DataPath, rules: Mapping[str, Any]) -> Derived:
    """Return the rule for the default of the key at ``path``, from the metadata of the key's dataclass field.

    ``rules`` has the field for each key of ``scene_keys``, such as "chain.links[].inertia".
    """
    key = "".join("[]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(".")
    rule: Derived = rules[key].metadata["default"]
    return rule
