"""The rules of a scene and of its variables: JavaScript finds the values that Python finds."""

# Tests: pages/browser/scene/rules.js

import numpy as np
import pytest

from chain_impact.scene.refusals import RULES, SIGNAL_RULES
from chain_impact.scene.rules import holds, names_in, number_in, tree
from chain_impact.variables.owners import CONDITIONS, COUNTS_OF, OWNER_KINDS, RECORD
from tests.pages.javascript import function_of
from tests.scene.rule_cases import CASES, VALUES

EVALUATED = function_of("rules", "evaluated")
ALL_RULES = [
    *(text for rule in (*RULES, *SIGNAL_RULES) for text in (rule.condition, rule.least) if text),
    *(condition.rule for condition in CONDITIONS.values()),
    *(text for row in OWNER_KINDS.values() for text in (row.over, row.has, *row.numbers.values())),
    *(text for row in OWNER_KINDS.values() for text in row.conditions.values()),
    *COUNTS_OF.values(),
    *(written.number for written in RECORD.values()),
]
NUMBERS = (None, 0, 1, 2, -1, 0.5, False, True)
TRIALS = 10


def in_both(script, rules, values):
    """Return whether each rule holds and its number, in Python and in a page."""
    page = script.evaluate(EVALUATED, [[tree(rule) for rule in rules], values])
    return [[holds(rule, values.get), number_in(rule, values.get)] for rule in rules], page


def texts_in(part, names):
    """Add the names that a rule compares with texts, each with these texts, to ``names``."""
    texts = [one["constant"] for one in part.get("parts", ()) if isinstance(one.get("constant"), str)]
    for one in part.get("parts", ()):
        texts_in(one, names)
        if texts and "name" in one:
            names.setdefault(one["name"], []).extend(texts)


def test_each_form_has_the_same_value(script):
    python, page = in_both(script, list(CASES), VALUES)
    assert page == python


@pytest.mark.parametrize("seed", range(TRIALS))
def test_all_rules_have_the_same_value_for_any_values(script, seed):
    chance, texts = np.random.default_rng(seed), {}
    for rule in ALL_RULES:
        texts_in(tree(rule), texts)
    names = {name for rule in ALL_RULES for name in names_in(tree(rule))}
    values = {name: NUMBERS[chance.integers(len(NUMBERS))] for name in sorted(names)}
    values |= {name: chance.choice([*found, "other"]) for name, found in texts.items()}
    python, page = in_both(script, ALL_RULES, values)
    assert page == python
