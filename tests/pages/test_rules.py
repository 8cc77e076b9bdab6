"""The rules of a scene and of its variables: JavaScript finds the values that Python finds."""

# Tests: pages/browser/scene/rules.js
# Tests: pages/browser/scene/owners.js

from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.scene.facts import FACTS, LISTS
from chain_impact.scene.rules.refusals import GIVEN_REFUSALS, REFUSALS, SIGNAL_REFUSALS
from chain_impact.scene.rules.rule_language import is_rule_true, names_in, number_in, tree
from chain_impact.variables.owners import COUNT_RULES, OWNER_KINDS, RECORD_NUMBERS
from tests.pages.javascript import function_of
from tests.scene.rule_cases import CASES, VALUES

EVALUATED = function_of("rules", "evaluated")
ALL_RULES = [
    *(
        text
        for rule in (*GIVEN_REFUSALS, *REFUSALS, *SIGNAL_REFUSALS)
        for text in (rule.condition, rule.least)
        if text
    ),
    *(fact.rule for fact in FACTS.values()),
    *(
        text
        for row in LISTS.values()
        for text in (row.source_list or "1", row.condition, *row.values.values())
    ),
    *(
        text
        for row in OWNER_KINDS.values()
        for text in (row.source_list, row.condition, *row.numbers.values())
    ),
    *(text for row in OWNER_KINDS.values() for text in row.conditions.values()),
    *COUNT_RULES.values(),
    *(text for row in RECORD_NUMBERS.values() for text in (row.number, row.source_list, row.at)),
]
NUMBERS = (None, 0, 1, 2, -1, 0.5, False, True)
TRIALS = 10


def in_both(script, rules, values):
    """Return whether each rule holds and its number, in Python and in a page.

    A file has only the keys of a table that have a value; in Python, the other keys are None.
    """
    page = script.evaluate(EVALUATED, [[tree(rule) for rule in rules], values])
    values = {name: in_tables(value) if "." in name else value for name, value in values.items()}
    return [[is_rule_true(rule, values.get), number_in(rule, values.get)] for rule in rules], page


def in_tables(value):
    """Return a list of tables in a file as Python has it, and any other value unchanged."""
    is_list = isinstance(value, list) and any(isinstance(entry, dict) for entry in value)
    return [Table(**entry) for entry in value] if is_list else value


class Table(SimpleNamespace):
    """A table of a scene, in which a missing key is None."""

    def __getattr__(self, name):
        """Return None for a key that the file leaves out."""
        return


def collect(part, texts, lists):
    """Collect from a rule the names that it compares with texts, each with them, and the names of lists."""
    parts = part.get("parts", ())
    of_part = [operand["constant"] for operand in parts if isinstance(operand.get("constant"), str)]
    if part.get("operator") in ("any", "sum"):
        lists[parts[0]["name"]] = {*names_in(parts[1])}
    for operand in parts:
        collect(operand, texts, lists)
        if of_part and "name" in operand:
            texts.setdefault(operand["name"], []).extend(of_part)


def test_each_form_has_the_same_value(script):
    python, page = in_both(script, list(CASES), VALUES)
    assert page == python


@pytest.mark.parametrize("seed", range(TRIALS))
def test_all_rules_have_the_same_value_for_any_values(script, seed):
    chance, texts, lists = np.random.default_rng(seed), {}, {}
    for rule in ALL_RULES:
        collect(tree(rule), texts, lists)
    names = sorted({name for rule in ALL_RULES for name in names_in(tree(rule))} - {"order"})

    def values_of(names):
        values = {name: NUMBERS[chance.integers(len(NUMBERS))] for name in names}
        return values | {name: chance.choice([*texts[name], "other"]) for name in names if name in texts}

    values = values_of(names) | {"order": 1}
    values |= {
        name: [values_of(sorted(entry_names)) for _ in range(seed % 4)] for name, entry_names in lists.items()
    }
    # no table in a list of a file is empty: each has a key that it must have
    for name in {name for name in lists if "." in name}:
        tables = ({key: value for key, value in table.items() if value is not None} for table in values[name])
        values[name] = [table for table in tables if table]
    values["inputs.wall_motion"] = ["*", "other"][: seed % 3]
    python, page = in_both(script, ALL_RULES, values)
    assert page == python
