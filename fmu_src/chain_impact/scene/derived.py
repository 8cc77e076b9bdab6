"""What a scene derives: the values that its file leaves to a default that follows from other values.

They stay derived until they are given: a scene is changed, written and compared by what is given, and
``Scene.derived_places`` has the paths of the rest. The kernel does the same with the parameters of a record:
kernel/chain/inertia.py.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from itertools import accumulate, pairwise
from typing import Any

from chain_impact.scene.limits import Derived
from chain_impact.scene.names import Place


def of_every_link(found: Iterable[Place], data: Mapping[str, Any]) -> Iterator[Place]:
    """The paths in the scene of what was derived in its data, where an entry can stand for several links."""
    counts = [entry.get("count") or 1 for entry in data["chain"]["links"]]
    links = [range(*ends) for ends in pairwise(accumulate(counts, initial=0))]
    for path in found:
        match path:
            case "chain", "links", int(entry), str(key):
                yield from (("chain", "links", i, key) for i in links[entry])
            case _:
                yield path


def without_derived(data: Any, derived: Iterable[Place], kept: Container[Place] = ()) -> None:
    """Remove from the data of a scene what is derived, but for some paths."""
    for path in derived:
        if path not in kept:
            *parents, key = path
            del functools.reduce(operator.getitem, parents, data)[key]


def above(paths: Iterable[Any]) -> set[Place]:
    """The paths to all that holds what is at some paths; what is no path has none."""
    proper = [
        path for path in paths if isinstance(path, tuple) and all(isinstance(one, str | int) for one in path)
    ]
    return {path[:k] for path in proper for k in range(1, len(path))}


def rule_at(rule: Derived, path: Place, links: Sequence[Any]) -> Derived:
    """The rule for the value at a path of a scene with these links: that of its key, or that for a box."""
    match path:
        case "chain", "links", int(i), _ if rule.of_box and links[i].shape:
            return rule.of_box
    return rule


def rule_of(path: Place, rules: Mapping[str, Any]) -> Derived:
    """The rule of a derived value; ``rules`` are the fields of all keys."""
    key = "".join("[]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(".")
    rule: Derived = rules[key].metadata["default"]
    return rule
