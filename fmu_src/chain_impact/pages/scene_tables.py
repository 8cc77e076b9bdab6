"""Tables for all scenes, for the page that simulates: keys of a scene file, variables, paths in the record.

The reader of the page edits scenes or opens files, so the number of links, walls and stops is not known. The
data therefore contain templates, such as ``link[{n}].angle``, from which the page makes the variables as
variables/scene_variables.py does, and the tables of scene/facts.py and variables/owners.py, which the page
evaluates. The index of a word in the record depends on the numbers of links, walls, stops and other parts.
The data contain the coefficients from which the page computes the index (compilation/affine.py). shared.py
has the constants of all pages.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, is_dataclass
from functools import cache, partial
from typing import Any, get_args, get_origin

import numpy as np

from chain_impact.compilation.affine import SAMPLES, affine
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import SIGNAL_DEGREE
from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.record.signals import signal_dtype
from chain_impact.pages.drawn_outputs import DRAWN_COLUMNS
from chain_impact.pages.signals import signal_table_data
from chain_impact.recording.impacts import LOG_DTYPE
from chain_impact.scene.facts import FACTS, LISTS, TRUE_FACT
from chain_impact.scene.reading import entry_type
from chain_impact.scene.rules.key_rules import Derived, allowed_text, key_fields, without_none
from chain_impact.scene.rules.rule_language import Tree, tree
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.input_table import INPUT_KINDS
from chain_impact.scene.texts.names import OWNER_AT, DataPath
from chain_impact.variables.description_texts import GENERAL, LOSSES
from chain_impact.variables.indices import layout_of, word_index
from chain_impact.variables.kind import GIVEN_CHANNEL, GIVEN_ONLY, LETTERS, Block, VariableKind, owner_path
from chain_impact.variables.outputs import INPUTS, OUTPUTS
from chain_impact.variables.owners import COUNT_RULES, OWNER_KINDS, RECORD_NUMBERS, Owner
from chain_impact.variables.parameters import PARAMETERS, SIMULATION_KINDS
from chain_impact.variables.peaks import PEAKS
from chain_impact.variables.scene_variables import choices_of
from chain_impact.variables.signal_filling import input_at
from chain_impact.variables.variable import UNLESS_SET, Item, Variable, variable_row

TEMPLATE_TEXTS = {word: f"{{{word}}}" for word in ("n", "of", "name", "before")}
"""Word in the texts of parameters and inputs → the word in braces, which the page replaces for each owner."""
LONGEST_TIME = 1e9
"""[s] The longest stop time, and the longest communication step, that a reader can set."""
COUNT_NAMES = {
    **dict.fromkeys(("link", "joint", "joint with friction", "stop"), "links"),
    **dict.fromkeys(("point", "contact"), "points"),
    "site": "sites",
}
"""Kind of owner of variables → what its number counts, if the removal of a link or point can change this
number."""
PATHS: dict[str, DataPath] = {
    **{name: row.path for name, row in RECORD_NUMBERS.items()},
    **{f"signal_{key}": ("signal", key, OWNER_AT) for key in signal_dtype(1, 1).names or ()},
    **{f"knot_{key}": ("knot", key, OWNER_AT) for key in ("given_time", "given_value", "time")},
    **{f"knot_power_{p}": ("knot", "powers", OWNER_AT, p) for p in range(SIGNAL_DEGREE + 1)},
}
"""Name → path in the record, for the values that the page sets by these names, not as named parameters.

They are counts and facts of the scene (RECORD_NUMBERS in variables/owners.py), and the data of signals and of
their knots.
"""


def page_kit(scene: Scene) -> dict[str, Any]:
    """Return the data, ready for JSON, with which the page handles any scene.

    Only the user's own contact law and the tables of signals depend on this ``scene``.
    """
    choices = choices_of(scene)
    inputs = [block for block in INPUTS if block.kinds[0].record_path[0] != GIVEN_CHANNEL]
    return {
        "keys": _keys(Scene),
        "facts": {name: tree(fact.rule) for name, fact in FACTS.items()},
        "lists": {
            name: {
                "sourceList": tree(row.source_list),
                "condition": tree(row.condition),
                "values": _trees(row.values),
            }
            for name, row in LISTS.items()
            if row.source_list
        },
        "counts": _trees(COUNT_RULES),
        "owners": {
            kind: {
                "sourceList": tree(row.source_list),
                "condition": tree(row.condition),
                "numbers": _trees(row.numbers),
                "conditions": _trees(row.conditions),
            }
            for kind, row in OWNER_KINDS.items()
        },
        "recordNumbers": {
            name: {"number": tree(row.number), "sourceList": tree(row.source_list), "at": tree(row.at)}
            for name, row in RECORD_NUMBERS.items()
        },
        "lawFile": scene.contact.law_file,
        "laws": scene.law_names,
        "parameters": [_group(block, partial(_setting_row, choices)) for block in PARAMETERS],
        "inputs": [_group(block, partial(_input_row, choices)) for block in inputs],
        "motions": [_group(block, _signal_row) for block in INPUTS if block not in inputs],
        "times": [
            _setting_row(choices, kind) | {"high": LONGEST_TIME, "word": None, "givenWord": None}
            for kind in SIMULATION_KINDS
        ],
        "outputs": [_group(block, _output_row) for block in OUTPUTS],
        "tables": signal_table_data(scene),
        "driven": [word_terms(("output", "signal", OWNER_AT, order)) for order in range(3)],
        "fields": {name: {"word": word_terms(path), "real": _is_real(path)} for name, path in PATHS.items()},
        "size": [*_affine(lambda record: record.itemsize // WORD), 0],
        "layout": _layout(),
        "points": [word_terms(("output", "point_position", OWNER_AT, axis)) for axis in (0, 1)],
    }


def _trees(rules: Mapping[str, str]) -> dict[str, Tree]:
    return {name: tree(rule) for name, rule in rules.items()}


def _keys(table: Any) -> dict[str, Any]:
    """Return name of a key → its data, for the keys of a table of the scene file.

    ``table`` is the table's dataclass.
    """
    return {entry.name: _key(entry.type, entry.metadata) for entry in key_fields(table)}


def _key(value_type: Any, metadata: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data by which the page checks a key of a scene file, from its type and its metadata.

    The key stands for a table, a list of tables, tables by name, a list of values, or a value; ``kind`` in
    the result tells which.
    """
    inner_type = entry_type(value_type := without_none(value_type))
    if is_dataclass(inner_type):
        kinds = {tuple: "tables", Mapping: "named"}
        return {
            "kind": kinds.get(get_origin(value_type), "table"),
            "keys": _keys(inner_type),
            **({"entries": metadata["entries"], "isNeeded": True} if metadata.get("entries") else {}),
            "meaning": metadata.get("description", ""),
        }
    item, *other_types = get_args(value_type) or (value_type,)
    value = _value(item, metadata)
    if other_types:
        length = "links" if metadata["per_link"] else None if ... in other_types else 1 + len(other_types)
        value = {
            "kind": "list",
            "meaning": metadata["description"],
            "length": length,
            "each": value,
            "orTrue": metadata["or_true"],
            "orOne": metadata["or_one"],
        }
    default = metadata["default"]
    if isinstance(default, Derived):
        # a default that follows from other values has no number here: the page or the kernel derives it
        or_key = {"orKey": default.or_key} if default.or_key else {}
        of_stops = {} if default.value_if_stops is None else {"ofStops": default.value_if_stops}
        return value | or_key | of_stops
    meaning = {"isNeeded": True, "meaning": metadata["description"]}
    return value | (meaning if default is MISSING else {"default": default})


def _value(value_type: Any, metadata: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data by which the page checks and labels a value, such as limits, choices and unit."""
    limits = {
        name: metadata[name]
        for name in ("minimum", "above", "maximum", "choices")
        if metadata[name] is not None
    }
    pattern = {"pattern": f"^(?:{metadata['pattern'][0]})$"} if metadata["pattern"] else {}
    if metadata["unit_by"]:
        limits["hasUnitOfInput"] = True
    if metadata["label"]:
        limits["label"] = metadata["label"]
    return (
        limits
        | pattern
        | {
            "kind": value_type.__name__,
            "unit": metadata["unit"],
            "allowed": allowed_text(value_type, metadata),
        }
    )


def _group(block: Block, row: Callable[[VariableKind], dict[str, Any]]) -> dict[str, Any]:
    """Return the data of a block of variables: its rows, and the kind of owner for which it is repeated.

    ``counts`` in the result is the value of COUNT_NAMES for this kind of owner; None for a kind without a
    value. ``row`` is the function that returns the data of one row.
    """
    counts = COUNT_NAMES.get(block.owner_kind)
    return {"ownerKind": block.owner_kind, "counts": counts, "rows": [row(kind) for kind in block.kinds]}


def _name_and_condition(kind: VariableKind) -> dict[str, Any]:
    """Return the template of a variable's name, and the conditions under which the variable exists."""
    return {"name": kind.name, "when": kind.when}


def _signal_row(kind: VariableKind) -> dict[str, Any]:
    """Return the data of an input that a signal can drive."""
    row = INPUT_KINDS[kind.name]
    determined = {"family": row.determined, "alone": row.exclusive}
    displaces = kind.owner_kind == "moving wall" and "position" in kind.record_path
    attributes = {"unit": kind.unit, "acts": input_at(kind.record_path), "displaces": displaces}
    return _name_and_condition(kind) | determined | attributes


def _input_row(choices: Mapping[str, Sequence[Item]], kind: VariableKind) -> dict[str, Any]:
    return _setting_row(choices, kind) | _signal_row(kind)


def _output_row(kind: VariableKind) -> dict[str, Any]:
    texts = defaultdict(str, GENERAL, n=LETTERS.get(kind.owner_kind, "i"), axis=kind.axis, losses=LOSSES)
    return _name_and_condition(kind) | {
        "unit": kind.unit,
        "text": kind.text.format_map(texts).rstrip(": "),
        "integer": not kind.unit,
        "word": word_terms(kind.record_path),
        "isPeakLoad": kind.owner_kind == "joint" and kind.record_path[1:3] == ("transmitted", "peak"),
        "drawn": DRAWN_COLUMNS.get((kind.parts.owner, kind.parts.quantity)),
    }


def _setting_row(choices: Mapping[str, Sequence[Item]], kind: VariableKind) -> dict[str, Any]:
    """Return the data of a parameter or an input: name, path, range, words, default, place in the record.

    ``choices``: name of an enumeration → its items.
    """
    items, rule = choices.get(kind.choices, ()), kind.derived
    variable = Variable.from_kind(kind, Owner(), TEMPLATE_TEXTS, items=tuple(items))
    row = variable_row(variable, 0, 0)
    table = kind.name.rpartition(".")[0]
    return _name_and_condition(kind) | {
        "unit": kind.unit,
        "path": kind.scene_path or (),
        "type": variable.type,
        "low": row.low,
        "high": row.high,
        "allowed": f"one of {', '.join(item.name for item in items)}" if items else variable.allowed,
        "text": variable.description,
        "items": [[item.name, _sentence(item)] for item in items],
        "rule": rule
        and {
            **_rule(rule, table),
            "ofBox": rule.of_box and _rule(rule.of_box, table),
        },
        "valueIfNotInFile": kind.value_if_not_in_file,
        # JSON in a text, because JSON itself has no infinite numbers
        "numberForNone": None if kind.owner_kind in GIVEN_ONLY else json.dumps(kind.number_for_none),
        "word": word_terms(kind.record_path) if kind.record_path else None,
        "givenWord": kind.given_path and word_terms(kind.given_path),
        "givenWordWhen": kind.stores_given_if or TRUE_FACT,
    }


def _rule(rule: Derived, table: str) -> dict[str, Any]:
    """Return the rule by which a parameter follows from other parameters, with complete names of these.

    A key without a dot belongs to the table ``table``.
    """
    term_keys = [[key if "." in key else f"{table}.{key}" for key in term] for term in rule.terms]
    return {"terms": term_keys, "divisor": rule.divisor, "text": UNLESS_SET + rule.text}


def _sentence(item: Item) -> str:
    """Return the sentence for a choice: its description, or for a contact law its range of use and source."""
    law = CONTACT_LAWS.get(item.name)
    return f"{law.limits} {law.source}." if law else item.description


def _layout() -> dict[str, Any]:
    """Return name → coefficients of the index, for the words from which the page reads a run's results.

    ``word_terms`` describes the coefficients.
    """
    record = layout_of(*SAMPLES[0])
    statistics = record["statistics"].names or ()
    return {
        "status": word_terms(("statistics", "status")),
        "part": word_terms(("fault", "part")),
        "time": word_terms(("step", "communication_point")),
        "impulses": word_terms(("quadrature", "computed")),
        "loads": word_terms(("transmitted_row_count",)),
        "contactLog": {
            "count": word_terms(("contact_log", "count")),
            "collected": word_terms(("contact_log", "collected")),
            "capacity": [*_affine(lambda record: record["contact_log"]["point"].shape[0]), 0],
            "fields": {name: word_terms(("contact_log", name, 0)) for name in LOG_DTYPE.names or ()},
        },
        "peaks": {name: word_terms(peak.path) for name, peak in PEAKS.items()},
        "frictionChanges": word_terms(("friction_changes", "count")),
        "pending": word_terms(("given", "pending")),
        "active": word_terms(("contacts", "active_count")),
        "statistics": {name: word_terms(("statistics", name)) for name in statistics},
    }


def _is_real(path: DataPath) -> bool:
    """Return whether the numbers at a path in the record are real numbers, not integers."""
    kind = layout_of(*SAMPLES[0])
    for step in path:
        kind = kind[step] if isinstance(step, str) and step != OWNER_AT else kind.base
    return kind.base == np.float64


@cache
def word_terms(path: DataPath) -> list[int]:
    """Return the coefficients of the index of a word in the record, and at the end the stride.

    The coefficients (``_affine``) are for ``{at}`` = 0 in the path; the stride [words] is the increase of the
    index when ``{at}`` increases by 1.
    """

    def word(record: np.dtype, index: int) -> int:
        return word_index(record, owner_path(path, {"at": index}))

    record = layout_of(*SAMPLES[0])
    return [*_affine(lambda record: word(record, 0)), word(record, 1) - word(record, 0)]


def _affine(number: Callable[[np.dtype], int]) -> list[int]:
    """Return the coefficients c₀, c₁, … of a number that ``number`` computes from the layout of a record.

    The number is c₀ + Σ cᵢ · countᵢ, with the counts in ``counts.COUNTS``, such as the number of links.
    """
    constant, slopes = affine([number(layout_of(*counts)) for counts in SAMPLES])
    return [constant, *slopes]
