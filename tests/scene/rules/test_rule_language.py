"""The language of rules: the meaning of each form, missing values, wrong rules, and the rules of a file."""

import re

import pytest

from chain_impact.scene.keys.chain_tables import Link
from chain_impact.scene.keys.signal_tables import Signal
from chain_impact.scene.keys.tables import Contact, Initial, Material, Simulation, Solver, Stops, Wall
from chain_impact.scene.rules.key_rules import key_fields
from chain_impact.scene.rules.refusals import (
    GIVEN_REFUSALS,
    LAW_FACTS,
    REFUSALS,
    SENTENCES,
    SIGNAL_REFUSALS,
    STOP_KEYS,
    RefusalRule,
)
from chain_impact.scene.rules.rule_language import is_rule_true, names_in, number_in, tree
from chain_impact.scene.scene import scene_keys
from tests.scene.rule_cases import CASES, VALUES

WRONG_RULES = (
    "a and",
    "a & b",
    "a - b",
    "a and or b",
    "max(a, b)",
    "sum(a)",
    "a < b < c",
    "has_value(x=a)",
    "a[0]",
)
ALL_KEYS = {key for key, _ in scene_keys()}
OF_LINK = {entry.name for entry in key_fields(Link)} | {"order"}
OF_LAW = {entry.name for entry in key_fields(Material)} | {"exponent"} | {f"law.{key}" for key in LAW_FACTS}
OF_WALL = {entry.name for entry in key_fields(Wall)}
NAMES = {"": ALL_KEYS | OF_LINK, "link": ALL_KEYS | OF_LINK, "wall": OF_WALL, "law": OF_LAW}
"""Table to which a rule belongs → the names that the rule may have."""


@pytest.mark.parametrize("rule", CASES)
def test_the_value_of_a_rule(rule):
    value = CASES[rule]
    if isinstance(value, bool):
        assert is_rule_true(rule, VALUES.__getitem__) == value
    else:
        assert number_in(rule, VALUES.__getitem__) == value


@pytest.mark.parametrize("rule", WRONG_RULES)
def test_a_wrong_rule_is_named(rule):
    with pytest.raises(ValueError, match=re.escape(rule)):
        tree(rule)


def test_an_unknown_name_is_an_error():
    with pytest.raises(KeyError, match="strange"):
        is_rule_true("a and strange", VALUES.__getitem__)


@pytest.mark.parametrize(
    "rule",
    [*GIVEN_REFUSALS, *REFUSALS, *SIGNAL_REFUSALS],
    ids=lambda rule: f"{rule.fault}, {rule.key}",
)
def test_the_rules_of_a_file_name_keys_and_facts(rule: RefusalRule):
    facts = {"moves", "order", "steps_differ", "starts_fast"} | {entry.name for entry in key_fields(Signal)}
    names = facts if rule in SIGNAL_REFUSALS else NAMES[rule.of]
    assert {rule.key, *names_in(tree(rule.condition))} <= names | {"", "initial"}
    assert {*names_in(tree(rule.least or "0"))} <= names
    assert rule.fault in SENTENCES


def test_each_key_of_stops_has_a_rule_for_scenes_without_stops():
    assert [entry.name for entry in key_fields(Stops)] == [*STOP_KEYS]


def test_no_rule_names_a_key_that_changes_without_the_rules():
    """``with_numbers`` leaves a restitution of 0, and the velocity of a held base, to a full reading."""
    lone_keys = {
        entry.name for table in (Contact, Link) for entry in key_fields(table) if entry.metadata["alone"]
    }
    for name, table in (
        ("contact", Contact),
        ("initial", Initial),
        ("simulation", Simulation),
        ("solver", Solver),
    ):
        lone_keys |= {f"{name}.{entry.name}" for entry in key_fields(table) if entry.metadata["alone"]}
    keys_in_rules = {name for rule in REFUSALS for name in (rule.key, *names_in(tree(rule.condition)))}
    assert keys_in_rules & lone_keys == {"restitution", "initial.velocity"}
