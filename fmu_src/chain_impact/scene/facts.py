"""Facts of a scene, such as whether it has friction, and lists of its parts.

The tables FACTS and LISTS have the rules that give facts and lists; rule_language.py has the language of the
rules. Lists without a rule are found by code, in Python by LIST_FUNCTIONS. Example: if a scene gives
``joint_friction`` for a link with a proximal joint, the link has the value ``has_friction`` 1 in
"link_facts", so the facts "has_joint_friction" and "has_dry_friction" are true.

The twin in JavaScript is pages/browser/scene/owners.js.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, partial
from itertools import accumulate
from typing import Any, NamedTuple

from chain_impact.kernel.constraints.geometry import AT_WALL, STOP_CODES
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.contents import SceneContents
from chain_impact.scene.keys.chain_tables import Link, Slider
from chain_impact.scene.keys.default_rules import ZERO_RULE
from chain_impact.scene.keys.tables import Contact
from chain_impact.scene.rules.key_rules import key_fields
from chain_impact.scene.rules.rule_language import (
    is_rule_true,
    member_lookups,
    members_in,
    number_in,
    value_of_key,
    value_within,
)
from chain_impact.scene.signals import signal_inputs_of
from chain_impact.scene.texts.input_table import INPUT_KEYS
from chain_impact.scene.texts.names import DataPath

TRUE_FACT = "always"
"""The name of the fact that is true for all scenes."""
_DEFAULT_KEYS = {
    entry.name
    for table in (Link, Slider, Contact)
    for entry in key_fields(table)
    if entry.metadata["default"] is ZERO_RULE
}
"""The names of keys with the default ZERO_RULE. A key of this kind that the file lacks has the value 0 in the
scene, but is missing for a rule."""


class ListRule(NamedTuple):
    """One of LISTS: the meaning of a list, and the rules that find its members and their values.

    Attributes:
        meaning: words for the members, and for the values that each member has.
        source_list: the list from which the members of this list are taken; "" for a list that LIST_FUNCTIONS
            and the page's code find without a rule.
        condition: the rule that is true if a member of ``source_list`` is a member of this list.
        values: name of a value that each member has → the rule for this value.
    """

    meaning: str
    source_list: str = ""
    condition: str = "1"
    values: Mapping[str, str] = {}


LISTS = {
    "sites": ListRule(
        "points of links other than the ends; link and entry: indices; corner: its number, from 1, if it is "
        "a corner of a box, else 0; label: its name"
    ),
    "candidates": ListRule(
        "pairs, stops, slider_stops; n: number of the point or joint, 0 at the slider; wall: index; "
        "name: of the wall or the slider's stop, missing at a joint; stop: STOP_CODES, 0 for a wall; "
        "at_joint: it is a joint's stop"
    ),
    "walls": ListRule(
        "walls and stops in the order of wall_names; name; exists: it is an existing wall; touched: a point "
        "can touch it, and it is no stop"
    ),
    "sloped_walls": ListRule("walls at any angle, if a point may touch a wall; name"),
    "laws": ListRule("contact laws, a user's law last; name"),
    "signals": ListRule("driven inputs; name: of the signal; input; knots: their number"),
    "steps": ListRule(
        "steps of each driven input; name: of the signal; input; entry: index; knot: index in record"
    ),
    "link_facts": ListRule(
        "jointed: a joint holds it; has_friction: this joint may have dry friction",
        source_list="chain.links",
        values={
            "jointed": "chain.base != 'free' or order > 0",
            "has_friction": "jointed and has_value(joint_friction)",
        },
    ),
    "moving_walls": ListRule(
        "walls that inputs move; name; number: index among the walls",
        source_list="walls",
        condition="exists and ('*' in inputs.wall_motion or name in inputs.wall_motion)",
        values={"name": "name", "number": "order"},
    ),
}
"""Name of a list of parts of a scene → its meaning and rules. In rules, a name without a dot is that of a
list, a fact, a count or a value of a member."""


class Fact(NamedTuple):
    """A fact of a scene, which is 0 or 1 or a count: the rule for its number, and its meaning in words."""

    rule: str
    meaning: str


FACTS = {
    TRUE_FACT: Fact("1", "all scenes have this"),
    "free": Fact("chain.base == 'free'", "the base is free"),
    "pinned": Fact("chain.base == 'pinned'", "the base is pinned"),
    "has_slider": Fact("chain.base == 'slider'", "the base is on a slider"),
    "has_base_joint": Fact("not free", "a joint connects link 1 with the base"),
    "skewed": Fact(
        "any(chain.links, has_value(center_of_mass_offset))",
        "the centre of mass of some link may lie beside the link's line",
    ),
    "pair_count": Fact(
        "sum(candidates, stop == 0)", "the number of pairs of a point and a wall that can touch"
    ),
    "stop_count": Fact("sum(candidates, at_joint)", "the number of stops in joints"),
    "slider_stop_count": Fact(
        "sum(candidates, stop != 0 and not at_joint)", "the number of stops of the slider"
    ),
    "has_contacts": Fact("pair_count or slider_stop_count", "a point can touch a wall, or a slider its stop"),
    "has_own_stop_law": Fact("has_value(stops.model)", "the file gives the law of stops in joints"),
    "has_law": Fact(
        "has_contacts or stop_count and not has_own_stop_law", "a contact may follow the law contact.model"
    ),
    "has_contact_friction": Fact(
        "pair_count and (has_value(contact.friction) or has_value(contact.static_friction) or "
        "any(contact.wall, has_value(friction) or has_value(static_friction)))",
        "a contact may have dry friction: a coefficient is given, even as 0",
    ),
    "has_joint_friction": Fact("any(link_facts, has_friction)", "a joint may have dry friction"),
    "has_slider_friction": Fact("has_value(chain.slider.friction)", "the slider may have dry friction"),
    "has_dry_friction": Fact(
        "has_contact_friction or has_joint_friction or has_slider_friction", "a part may have dry friction"
    ),
    "has_inputs": Fact(
        " or ".join(f"inputs.{key}" for key in INPUT_KEYS if key != "wall_motion"),
        "there are inputs other than motions of walls",
    ),
    "has_limits": Fact(
        "has_value(chain.slider.force_limit) or any(chain.links, has_value(joint_torque_limit))",
        "a drive has a largest torque or force",
    ),
    "has_motions": Fact("inputs.base_motion or moving_walls", "inputs move the base or walls"),
    "has_general_bodies": Fact(
        "skewed or has_slider or sites",
        "there is a slider, an additional point of a link, or a given center_of_mass_offset",
    ),
    "has_supply": Fact("has_inputs or inputs.wall_motion or has_limits", "energy may be supplied"),
    "needs_impulses": Fact(
        "outputs.contacts or outputs.impacts or outputs.loads or has_dry_friction and outputs.energies",
        "some output needs the impulses of contacts",
    ),
}
"""Name → fact of a scene. A fact comes after the facts that its rule names. ``SceneFacts`` has further facts:
the keys of [inputs] and [outputs], such as ``inputs.tip_force``."""


class SceneFacts(dict[str, Any]):
    """Name → fact or list of a scene; each fact and each list is computed when it is first read.

    The keys of [inputs] and [outputs] are facts, too, such as ``inputs.tip_force``.
    """

    def __init__(self, scene: SceneContents) -> None:
        super().__init__()
        self.scene = scene

    def __missing__(self, name: str) -> Any:
        """Compute, store and return the fact or list ``name``; Python calls this at the first use of a name.

        A fact is a whole number: 0 or 1, or a count. A list is a list of dicts, one for each member. A key of
        [inputs] or [outputs] gives its value as a whole number; a list as value gives the number of entries.

        Raises:
            KeyError: when there is no such fact or list.
            AttributeError, ValueError: when ``name`` has a dot and is no key of [inputs] or [outputs].
        """
        value: Any
        if name in FACTS:
            value = int(number_in(FACTS[name].rule, self.value_of))
        elif name in LISTS:
            value = self._members(LISTS[name]) if LISTS[name].source_list else LIST_FUNCTIONS[name](self)
        elif "." in name:
            flag = value_of_key(self.scene, name)
            value = len(flag) if isinstance(flag, tuple) else int(flag)
        else:
            raise KeyError(name)
        self[name] = value
        return value

    def value_of(self, name: str) -> Any:
        """Return the value that ``name`` has in a rule; None if the value is missing.

        A name with a dot is a key of the scene's file, any other name a fact or a list of ``LISTS``. The
        value of a key with the default ``ZERO_RULE`` is missing unless the file gives the key.
        """
        if "." not in name:
            return self[name]
        if name == "chain.links":
            return self._links
        return None if tuple(name.split(".")) in self._unused_paths else value_of_key(self.scene, name)

    @cached_property
    def _unused_paths(self) -> frozenset[DataPath]:
        return frozenset(path for path in self.scene.derived_paths if path[-1] in _DEFAULT_KEYS)

    @cached_property
    def _links(self) -> tuple[Link, ...]:
        """The links as rules see them: a key in ``_DEFAULT_KEYS`` that the file does not give is None."""
        missing_links: dict[int, dict[str, Any]] = {}
        for path in self._unused_paths:
            match path:
                case "chain", "links", int(i), str(key):
                    missing_links.setdefault(i, {})[key] = None
        links = self.scene.chain.links
        return tuple(replace(link, **missing_links.get(i, {})) for i, link in enumerate(links))

    def _members(self, row: ListRule) -> list[dict[str, Any]]:
        """Return the members of the list ``row``, each as a table from the names in ``row.values`` to values.

        The members are those of the list ``row.source_list`` for which the rule ``row.condition`` is true.
        Each value is computed by its rule in ``row.values``.
        """
        members = list[dict[str, Any]]()
        for order, of_member in enumerate(
            member_lookups(members_in(row.source_list, self.value_of), self.value_of)
        ):
            if is_rule_true(row.condition, of_member):
                values = dict[str, Any]()
                for key, rule in row.values.items():
                    values[key] = number_in(rule, partial(value_within, values, order, of_member))
                members.append(values)
        return members


def friction_joints(scene: SceneContents) -> tuple[int, ...]:
    """Return the numbers of the existing joints whose ``joint_friction`` the file gives, even as 0.

    With a free base, joint 1 does not exist.
    """
    return tuple(n for n, link in enumerate(SceneFacts(scene)["link_facts"], 1) if link["has_friction"])


def _sites(facts: SceneFacts) -> list[dict[str, Any]]:
    return [
        {"link": i, "entry": j, "corner": j + 1 if j < link.corners else 0, "label": site.name}
        for i, link in enumerate(facts.scene.chain.links)
        for j, site in enumerate(link.points)
    ]


def _candidates(facts: SceneFacts) -> list[dict[str, Any]]:
    names, members = facts.scene.wall_names, list[dict[str, Any]]()
    stops = [STOP_CODES.get(facts.scene.stop_name(wall), AT_WALL) for wall in range(len(names))]
    for n, wall in candidates_of(facts.scene):
        is_at_joint = stops[wall] != AT_WALL and n > 0
        label = {} if is_at_joint else {"name": names[wall]}
        members.append({"n": n, "wall": wall, "stop": stops[wall], "at_joint": is_at_joint, **label})
    return members


def _walls(facts: SceneFacts) -> list[dict[str, Any]]:
    scene, existing = facts.scene, facts.scene.half_planes
    touched_walls = {candidate["wall"] for candidate in facts["candidates"] if candidate["stop"] == AT_WALL}
    return [
        {"name": name, "exists": name in existing, "touched": w in touched_walls}
        for w, name in enumerate(scene.wall_names)
    ]


def _signals(facts: SceneFacts) -> list[dict[str, Any]]:
    return [
        {"name": signal.signal, "input": signal.input, "knots": signal.knot_count}
        for signal in signal_inputs_of(facts.scene)
    ]


def _steps(facts: SceneFacts) -> list[dict[str, Any]]:
    signals = signal_inputs_of(facts.scene)
    first = accumulate((signal.knot_count for signal in signals), initial=0)
    return [
        {"name": signal.signal, "input": signal.input, "entry": k, "knot": knot + k}
        for signal, knot in zip(signals, first, strict=False)
        if signal.is_steps
        for k in range(signal.knot_count)
    ]


LIST_FUNCTIONS: dict[str, Callable[[SceneFacts], list[dict[str, Any]]]] = {
    "sites": _sites,
    "candidates": _candidates,
    "walls": _walls,
    "sloped_walls": lambda facts: [
        {"name": wall.name} for wall in facts.scene.walls if facts.scene.may_touch
    ],
    "laws": lambda facts: [{"name": name} for name in facts.scene.law_names],
    "signals": _signals,
    "steps": _steps,
}
"""Name of a list in LISTS that no rule finds → function that returns its members from the facts."""
