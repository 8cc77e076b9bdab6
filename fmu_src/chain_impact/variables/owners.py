"""The tables of conditions, counts and owners of variables, and of numbers in a record that follow from them.

Python (structure.py) and a page (pages/browser/scene/owners.js) evaluate the same tables. Each of them finds
only the FACTS and the LISTS of a scene by itself. Conditions and numbers are in the language of
scene/rules.py; a list counts as its length.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from chain_impact.kernel.record.counts import COUNTS
from chain_impact.scene.names import AT, INPUTS_OF, DataPath
from chain_impact.scene.rules import holds, number_in
from chain_impact.scene.scene import Scene
from chain_impact.scene.signals import Driven
from chain_impact.variables.kind import ALWAYS


class Parts(NamedTuple):
    """A scene, its candidates, and the inputs that its signals drive."""

    scene: Scene
    pairs: Sequence[tuple[int, int]]
    signals: Sequence[Driven]


class Fact(NamedTuple):
    """A fact of a scene: its meaning, and the function that returns it for the parts of the scene."""

    meaning: str
    of: Callable[[Parts], int]


FACTS = {
    ALWAYS: Fact("all scenes have this", lambda _: True),
    "free": Fact("no base holds the chain", lambda of: of.scene.chain.base == "free"),
    "pinned": Fact("the base is pinned", lambda of: of.scene.chain.base == "pinned"),
    "slider": Fact("the base is on a slider", lambda of: of.scene.chain.base == "slider"),
    "skewed": Fact(
        "the centre of mass of some link lies beside the link's line", lambda of: of.scene.chain.is_skewed
    ),
    "contact_friction": Fact("a contact may have dry friction", lambda of: of.scene.has_contact_friction),
    "joint_friction": Fact("a joint has dry friction", lambda of: bool(of.scene.friction_joints)),
    "slider_friction": Fact(
        "the slider has dry friction",
        lambda of: of.scene.chain.slider is not None and of.scene.chain.slider.friction > 0.0,
    ),
    "own_stop_law": Fact("stops have another law than walls", lambda of: of.scene.stops.model is not None),
    "has_limits": Fact("a drive has a largest torque or force", lambda of: of.scene.chain.has_limits),
    "pairs": Fact(
        "the number of pairs of a point and a wall that can touch",
        lambda of: len(of.pairs) - len(of.scene.chain.stops) - len(of.scene.slider_stops),
    ),
    "stops": Fact("the number of stops in joints", lambda of: len(of.scene.chain.stops)),
    "slider_stops": Fact("the number of stops of the slider", lambda of: len(of.scene.slider_stops)),
    "knots": Fact(
        "the number of knots of all signals", lambda of: sum(driven.knots for driven in of.signals)
    ),
}
"""Name → fact of a scene. The keys of [inputs] and [outputs] are facts, too, as
``inputs.tip_force``; a list of names counts as its length."""
LISTS = {
    "links": "jointed: a joint holds it; has_friction: this joint has dry friction",
    "sites": "points of links; link and entry: indices; corner: of a box, from 1, or 0; label",
    "candidates": "pairs, stops, slider_stops; n: point or joint; wall: index; name: of the wall, "
    "a joint's stop has none; stop: code of the stop, 0 for none; at_joint: it is a joint's stop",
    "walls": "numbered walls; name; exists: it is a wall, no stop; touched: a point can touch it",
    "lines": "walls at any angle; name",
    "moving_walls": "walls that inputs move; name",
    "signals": "driven inputs; name: of the signal; input",
    "steps": "steps of each driven input; name: of the signal; input; entry: index; knot: index in record",
}
"""Name → members of each list of a scene, with the values that each member has."""


class Condition(NamedTuple):
    """A condition of variables: the rule by which it holds, and its meaning."""

    rule: str
    meaning: str


CONDITIONS = {
    "contacts": Condition("pairs or slider_stops", "a point can touch a wall, or a slider its stop"),
    "law": Condition("contacts or stops and not own_stop_law", "the law of contacts acts"),
    "friction": Condition("contact_friction or joint_friction or slider_friction", "a part has dry friction"),
    "has_base_joint": Condition("not free", "a joint connects link 1 with the base"),
    "has_inputs": Condition(
        " or ".join(f"inputs.{key}" for key in INPUTS_OF if key != "wall_motion"),
        "inputs act on the chain without contact",
    ),
    "supply": Condition("has_inputs or inputs.wall_motion or has_limits", "energy may be supplied"),
    "impulses": Condition(
        "outputs.contacts or outputs.impacts or outputs.loads or friction and outputs.energies",
        "some output needs the impulses of contacts",
    ),
}
"""Conditions of a scene, beside its facts and lists; a rule may name conditions before it."""
OWN_CONDITIONS = {
    "has_target": "the target of the joint's spring is an input",
    "target_is_parameter": "the target of the joint's or slider's spring is a parameter",
    "may_have_friction": "the joint, slider or contact may have dry friction",
    "in_file": "the file has the point; it is no corner of a box",
    "base_at_rest": "the point is a base that cannot move",
}
"""Name → meaning of the conditions of owners. None has the name of a condition of scenes."""
COUNTS_OF = {
    "links": "links",
    "candidates": "candidates",
    "elements": "friction*links + friction*candidates + friction*slider",
    "loads": "outputs.loads*links + outputs.loads*walls",
    "channels": "2*inputs.base_motion + 2*moving_walls",
    "sites": "sites",
    "signals": "signals",
    "knots": "knots",
}
"""Name → number (a sum of products) for each count at the start of a record (kernel/record/counts.py)."""


@dataclass(frozen=True, kw_only=True)
class OwnerKind:
    """A kind of owners: a row of the table of owners.

    Attributes:
        over: the name of the list whose members can be owners, or the number of owners.
        has: the rule by which a member is an owner. Only the first of members with equal ``n``, ``of``
            and name is an owner: the two stops of joint 2 are one owner.
        numbers: the numbers of an owner: ``n`` its number, ``at`` its index in the record, ``of`` the number
            of its link. ``order`` is the index of the member in the list.
        conditions: name in OWN_CONDITIONS → rule by which an owner meets the condition.
    """

    over: str
    has: str = ALWAYS
    numbers: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, str] = field(default_factory=dict)


_COUNTED = {"n": "order + 1", "at": "order"}
OWNER_KINDS = {
    "one": OwnerKind(over="1"),
    "link": OwnerKind(
        over="links",
        numbers=_COUNTED,
        conditions={
            "has_target": "inputs.joint_targets and jointed",
            "target_is_parameter": "not has_target",
            "may_have_friction": "has_friction",
        },
    ),
    "point": OwnerKind(
        over="links + sites + 1",
        numbers={"n": "order", "at": "order"},
        conditions={"base_at_rest": "pinned and not inputs.base_motion and not order"},
    ),
    "joint": OwnerKind(over="links", has="jointed", numbers=_COUNTED),
    "joint with friction": OwnerKind(over="links", has="has_friction", numbers=_COUNTED),
    # the record has the outputs of both stops of a joint at the candidate of its first stop
    "stop": OwnerKind(over="candidates", has="at_joint", numbers={"at": "order"}),
    "contact": OwnerKind(
        over="candidates",
        has="not at_joint",
        numbers={"at": "order"},
        conditions={"may_have_friction": "contact_friction and not stop"},
    ),
    "site": OwnerKind(
        over="sites",
        numbers={"n": "entry + 1", "of": "link + 1", "at": "order"},
        conditions={"in_file": "not corner"},
    ),
    "slider": OwnerKind(
        over="slider",
        numbers={"at": "links"},
        conditions={
            "target_is_parameter": "not inputs.joint_targets",
            "may_have_friction": "slider_friction",
        },
    ),
    "line": OwnerKind(over="lines", numbers={"at": "order"}),
    # where points may touch, each wall that exists has a material
    "material": OwnerKind(over="walls", has="exists and pairs", numbers={"at": "order"}),
    "moving wall": OwnerKind(over="moving_walls", numbers={"at": "2*inputs.base_motion + 2*order"}),
    "touched wall": OwnerKind(over="walls", has="touched", numbers={"at": "links + order"}),
    "signal": OwnerKind(over="signals", numbers={"at": "order"}),
    "step": OwnerKind(over="steps", numbers={"n": "entry + 1", "at": "knot"}),
    "impact": OwnerKind(over="outputs.impacts", numbers=_COUNTED),
}
"""Kind of owner → its owners, in the order of their variables."""


class Written(NamedTuple):
    """A number in the record that follows from the tables; one for each member of ``over``, if given."""

    path: DataPath
    number: str
    over: str = ""


RECORD = {
    **{name: Written((name,), name) for name in COUNTS},
    "skewed": Written(("skewed",), "skewed"),
    "slides": Written(("slides",), "slider"),
    "has_base_joint": Written(("model", "has_base_joint"), "has_base_joint"),
    "has_inputs": Written(("model", "has_inputs"), "has_inputs"),
    "has_servos": Written(("model", "has_servos"), "inputs.joint_targets"),
    "base_moves": Written(("model", "base_moves"), "inputs.base_motion"),
    "interpolates": Written(("motion", "interpolates"), ALWAYS),
    "kept": Written(("latest", "kept"), "outputs.impacts"),
    "impulses": Written(("quadrature", "computed"), "impulses"),
    "site_link": Written(("site", "link", AT), "link", "sites"),
    "site_corner": Written(("site", "corner", AT), "corner", "sites"),
    "candidate_point": Written(("candidate", AT, "point"), "n", "candidates"),
    "candidate_wall": Written(("candidate", AT, "wall"), "wall", "candidates"),
    "candidate_stop": Written(("candidate", AT, "stop"), "stop", "candidates"),
}
"""Name → numbers of the record that are no parameters."""


@dataclass(frozen=True, slots=True)
class Owner:
    """An owner of variables.

    Attributes:
        values: number ``n``, name, index ``at`` in the record, and the values of the member of its list.
        conditions: condition → whether the owner or its scene meets it.
    """

    values: dict[str, Any] = field(default_factory=dict)
    conditions: dict[str, Any] = field(default_factory=dict)


def with_conditions(facts: Mapping[str, int], lists: Mapping[str, Sequence[Any]]) -> dict[str, int]:
    """Return the facts of a scene with its conditions, the lengths of its lists, and its counts."""
    known = {**facts, **{name: len(members) for name, members in lists.items()}}
    for name, condition in CONDITIONS.items():
        known[name] = holds(condition.rule, known.__getitem__)
    return known | {name: number_in(text, known.__getitem__) for name, text in COUNTS_OF.items()}


def owners_of(
    kind: str, known: Mapping[str, Any], lists: Mapping[str, Sequence[Mapping[str, Any]]]
) -> list[Owner]:
    """Return the owners of a kind, in the order of their variables."""
    row, found = OWNER_KINDS[kind], dict[Any, Owner]()
    for order, member in enumerate(lists.get(row.over) or [{}] * number_in(row.over, known.__getitem__)):
        here = {**known, **member, "order": order}
        if holds(row.has, here.__getitem__):
            numbers = {name: number_in(text, here.__getitem__) for name, text in row.numbers.items()}
            values = {**member, **numbers}
            for name, rule in row.conditions.items():
                here[name] = holds(rule, here.__getitem__)
            found.setdefault(tuple(map(values.get, ("n", "of", "name"))), Owner(values, here))
    return list(found.values())
