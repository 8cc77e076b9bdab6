"""Tables of rules that find the owners of a scene's variables, their conditions, and numbers of the record.

An owner is a part of a scene that has variables, such as a link. The rules are in the language of
rule_language.py and name facts and lists of scene/facts.py; structure.py evaluates them. Example: a link with
``has_friction`` is an owner of the kind "joint with friction", which has the outputs of dry friction; the
record has room for these outputs, because the fact "has_dry_friction" is true.
The twin in JavaScript is pages/browser/scene/owners.js.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

from chain_impact.kernel.record.constants import NO_CONTACT, WALLS
from chain_impact.kernel.record.counts import COUNTS
from chain_impact.scene.facts import FACTS, LISTS, TRUE_FACT, SceneFacts
from chain_impact.scene.keys.tables import Inputs, Outputs
from chain_impact.scene.rules.rule_language import ValueOf, is_rule_true, members_in, number_in, value_of_key
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.names import OWNER_AT, DataPath

REQUEST_KEYS = [
    f"{name}.{entry.name}"
    for name, table in (("inputs", Inputs), ("outputs", Outputs))
    for entry in fields(table)
]
"""The keys of [inputs] and [outputs]. Conditions of variables may name these keys. The value of a key counts
as a whole number; a list, as the number of entries."""


OWN_CONDITIONS = {
    "has_target": "the target of the joint's or slider's spring is an input",
    "target_is_parameter": "the target of the joint's or slider's spring is a parameter",
    "may_have_friction": "the joint, slider or contact may have dry friction",
    "in_file": "the file has the point; it is not a corner of a box",
    "base_at_rest": "the point is a base that cannot move",
}
"""Name of a condition that single owners meet, not the scene → its meaning. No such condition has the name of
a fact."""
COUNT_RULES = {
    "link_count": "link_facts",
    "candidate_count": "candidates",
    "friction_element_count": (
        "has_dry_friction*link_facts + has_dry_friction*candidates + has_dry_friction*has_slider"
    ),
    "transmitted_row_count": "outputs.loads*link_facts + outputs.loads*walls",
    "channel_count": "2*inputs.base_motion + 2*moving_walls",
    "site_count": "sites",
    "signal_count": "signals",
    "knot_count": "sum(signals, knots)",
}
"""Name of a count at the start of a record (kernel/record/counts.py) → the rule for its number."""


@dataclass(frozen=True, kw_only=True)
class OwnerKind:
    """The rules that find the owners of one kind, one row of the table of owners.

    In the rules ``condition``, ``numbers`` and ``conditions``, ``order`` is the index of the member in the
    list.

    Attributes:
        source_list: the list whose members can be owners; or a rule for the number of members, if these have
            no values.
        condition: the rule that is true if a member is an owner. If several such members have the same ``n``,
            ``of`` and ``name``, only the first is an owner: the two stops of joint 2 are one owner.
        numbers: name of a number → the rule for this number of an owner. ``n`` is the number in names of
            variables, ``at`` the index in the record, ``of`` the number of the owner's link.
        conditions: name in OWN_CONDITIONS → rule that is true if an owner meets the condition.
    """

    source_list: str
    condition: str = TRUE_FACT
    numbers: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, str] = field(default_factory=dict)


_NUMBERED_BY_ORDER = {"n": "order + 1", "at": "order"}
_CHANNEL = "2*inputs.base_motion + 2*order"
OWNER_KINDS = {
    "one": OwnerKind(source_list="1"),
    "link": OwnerKind(
        source_list="link_facts",
        numbers=_NUMBERED_BY_ORDER,
        conditions={
            "has_target": "inputs.joint_targets and jointed",
            "target_is_parameter": "not has_target",
            "may_have_friction": "has_friction",
        },
    ),
    "point": OwnerKind(
        source_list="link_count + site_count + 1",
        numbers={"n": "order", "at": "order"},
        conditions={"base_at_rest": "pinned and not inputs.base_motion and not order"},
    ),
    "joint": OwnerKind(source_list="link_facts", condition="jointed", numbers=_NUMBERED_BY_ORDER),
    "joint with friction": OwnerKind(
        source_list="link_facts", condition="has_friction", numbers=_NUMBERED_BY_ORDER
    ),
    # the outputs for both stops of a joint are at one index of the record: that of the joint's first stop
    "stop": OwnerKind(source_list="candidates", condition="at_joint", numbers={"at": "order"}),
    "contact": OwnerKind(
        source_list="candidates",
        condition="not at_joint",
        numbers={"at": "order"},
        conditions={"may_have_friction": "has_contact_friction and not stop"},
    ),
    "site": OwnerKind(
        source_list="sites",
        numbers={"n": "entry + 1", "of": "link + 1", "at": "order"},
        conditions={"in_file": "not corner"},
    ),
    "slider": OwnerKind(
        source_list="has_slider",
        numbers={"at": "link_count"},
        conditions={
            "has_target": "inputs.joint_targets",
            "target_is_parameter": "not has_target",
            "may_have_friction": "has_slider_friction",
        },
    ),
    "sloped wall": OwnerKind(source_list="sloped_walls", numbers={"at": "order"}),
    # if a point can touch a wall, each wall of the scene has a material, also a wall that no point can touch
    "material": OwnerKind(source_list="walls", condition="exists and pair_count", numbers={"at": "order"}),
    "moving wall": OwnerKind(source_list="moving_walls", numbers={"at": _CHANNEL}),
    "touched wall": OwnerKind(source_list="walls", condition="touched", numbers={"at": "link_count + order"}),
    "signal": OwnerKind(source_list="signals", numbers={"at": "order"}),
    "step": OwnerKind(source_list="steps", numbers={"n": "entry + 1", "at": "knot"}),
    "impact": OwnerKind(source_list="outputs.impacts", numbers=_NUMBERED_BY_ORDER),
}
"""Kind of owner → the rules that find the owners of this kind."""


class RecordNumber(NamedTuple):
    """One or several numbers in the record that are no parameters but follow from a rule.

    Attributes:
        path: the path of the number in the record; with OWNER_AT, of several numbers.
        number: the rule for the number.
        source_list: the name of a list, each member of which has a number; or a rule for the count of the
            numbers.
        at: for several numbers: the rule for the index that replaces OWNER_AT for a member.
    """

    path: DataPath
    number: str
    source_list: str = "1"
    at: str = "order"


RECORD_NUMBERS = {
    **{name: RecordNumber((name,), name) for name in COUNTS},
    "skewed": RecordNumber(("skewed",), "skewed"),
    "slides": RecordNumber(("slides",), "has_slider"),
    "has_base_joint": RecordNumber(("chain", "has_base_joint"), "has_base_joint"),
    "has_inputs": RecordNumber(("chain", "has_inputs"), "has_inputs"),
    "has_targets": RecordNumber(("chain", "has_targets"), "inputs.joint_targets"),
    "base_moves": RecordNumber(("chain", "base_moves"), "inputs.base_motion"),
    "interpolates": RecordNumber(("given_channel", "interpolates"), TRUE_FACT),
    "requested": RecordNumber(("latest", "requested_count"), "outputs.impacts"),
    "impulses": RecordNumber(("quadrature", "computed"), "needs_impulses"),
    "site_link": RecordNumber(("site", "link", OWNER_AT), "link", "sites"),
    "site_corner": RecordNumber(("site", "corner", OWNER_AT), "corner", "sites"),
    "candidate_point": RecordNumber(("candidate", OWNER_AT, "point"), "n", "candidates"),
    "candidate_wall": RecordNumber(("candidate", OWNER_AT, "wall"), "wall", "candidates"),
    "candidate_stop": RecordNumber(("candidate", OWNER_AT, "stop"), "stop", "candidates"),
    "regularized_candidate": RecordNumber(("step", "regularized_candidate"), f"{NO_CONTACT}"),
    # a moving wall has two channels (prescribed motions): its displacement, and its motion as a belt
    "belt": RecordNumber(("given_channel", "belt", OWNER_AT), "1", "moving_walls", at=f"{_CHANNEL} + 1"),
    "candidate_channel": RecordNumber(
        ("wall_motion", OWNER_AT, "first_channel"),
        f"sum(moving_walls, (number == wall)*({_CHANNEL} + 1)) + -1",
        "candidates",
    ),
    "stop_law": RecordNumber(("stops", "law"), "sum(laws, (name == stops.model)*(order + 1))"),
    **{
        f"wall_{key}": RecordNumber(("walls", key, OWNER_AT), "-1", f"{len(WALLS)} + candidate_count")
        for key in ("restitution", "friction", "static_friction")
    },
}
"""Name → the rules for one or several numbers of the record that are no parameters."""


@dataclass(frozen=True, slots=True)
class Owner:
    """An owner of variables, such as link 2.

    Attributes:
        values: the values of the owner's member of the list ``OwnerKind.source_list``, and the numbers in
            ``OwnerKind.numbers``.
        conditions: name of a condition → value that counts as true if the owner, or the scene, meets the
            condition; other numbers of the scene, and the values of the member, are there, too.
    """

    values: dict[str, Any] = field(default_factory=dict)
    conditions: dict[str, Any] = field(default_factory=dict)


def rule_value_function(
    scene_numbers: Mapping[str, Any], lists: Mapping[str, Sequence[Any]], scene: Scene | None = None
) -> ValueOf:
    """Return the function from a name in a rule to its value, for the rules of the tables in this file.

    ``lists`` has the values of lists, ``scene_numbers`` those of all other names without a dot. A name with a
    dot is a key of the scene's file: any key if ``scene`` is given; else it must be one of REQUEST_KEYS, in
    ``scene_numbers``.
    """

    def value_of(name: str) -> Any:
        if scene is not None and "." in name:
            return value_of_key(scene, name)
        return lists[name] if name in lists else scene_numbers[name]

    return value_of


def numbers_of_scene(facts: SceneFacts) -> dict[str, int]:
    """Return name → number for REQUEST_KEYS, FACTS, COUNT_RULES, and the length of each list in LISTS."""
    counts = {name: number_in(rule, facts.value_of) for name, rule in COUNT_RULES.items()}
    lengths = {name: len(facts[name]) for name in LISTS}
    return {name: facts[name] for name in (*REQUEST_KEYS, *FACTS)} | lengths | counts


def owners_of(
    kind: str, scene_numbers: Mapping[str, Any], lists: Mapping[str, Sequence[Mapping[str, Any]]]
) -> list[Owner]:
    """Return the owners of a kind, in the order of their variables.

    ``scene_numbers`` and ``lists`` have the values of the names in the rules (``rule_value_function``).
    """
    row, found_owners = OWNER_KINDS[kind], dict[Any, Owner]()
    for order, member in enumerate(members_in(row.source_list, rule_value_function(scene_numbers, lists))):
        member_names = {**scene_numbers, **member, "order": order}
        if is_rule_true(row.condition, member_names.__getitem__):
            numbers = {name: number_in(rule, member_names.__getitem__) for name, rule in row.numbers.items()}
            values = {**member, **numbers}
            for name, rule in row.conditions.items():
                member_names[name] = is_rule_true(rule, member_names.__getitem__)
            found_owners.setdefault(tuple(map(values.get, ("n", "of", "name"))), Owner(values, member_names))
    return list(found_owners.values())
