"""Constants of Python modules that pages need, too: numbers, names and words.

The program of each page begins with these constants, in the constant ``SHARED``. The constants do not depend
on a scene; scene_tables.py has the data on scenes, which only the page that simulates needs. A page computes
some things again that Python computes for pictures and films, because the reader of the page changes the
scene. For these things, tests/pages/test_twins.py compares the values of both languages.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np

from chain_impact import map_colours
from chain_impact.kernel.chain.inertia import corner_of_box
from chain_impact.kernel.chain.inputs import REINITIALIZE
from chain_impact.kernel.chain.signals import TRAPEZOID_KNOTS
from chain_impact.kernel.constraints.geometry import BOX_NORMALS, STOP_CODES
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import NOT_GIVEN, PARALLEL_COSINE, WALLS
from chain_impact.kernel.record.counts import COUNTS
from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STARTS_INSIDE_WALL, STATUS_TEXT
from chain_impact.pages.drawn_outputs import GROUPS, IMPACT_QUANTITIES
from chain_impact.recording import curves, joint_stops, pacing, view
from chain_impact.scene import errors
from chain_impact.scene.checks.signal_checks import REST_TOLERANCE
from chain_impact.scene.display import outlines
from chain_impact.scene.keys import chain_tables
from chain_impact.scene.keys.signal_tables import FORMS, NUMBERS, SHAPES
from chain_impact.scene.keys.tables import STEP_ROUND_OFF
from chain_impact.scene.rules.refusals import (
    ENTRY_REFUSALS,
    GIVEN_REFUSALS,
    LAW_FACTS,
    REFUSALS,
    SENTENCES,
    SIGNAL_REFUSALS,
    RefusalRule,
)
from chain_impact.scene.rules.rule_language import tree
from chain_impact.scene.signals import TARGET_RATE
from chain_impact.scene.texts import angles, names, similar_names, unit_text
from chain_impact.scene.texts.laws import law_group, law_text
from chain_impact.variables.impact_units import IMPACT_UNITS, STOP_UNITS
from chain_impact.variables.peaks import PEAKS
from chain_impact.variables.units import UNITS

FINEST = 65535  # the largest unsigned integer of 16 bits, for the largest value of packed numbers

CONSTANTS = {
    "pacing": (
        pacing,
        "CONTACT_SHARES FLIGHT_STEP FRAMES_OF_A_PERIOD FRAME_RATE IMPACT_TIME INSTANT LEAST_DURATION"
        " LEAST_SPEED LONGEST_IMPACT LONGEST_SLOW MOST_FRAMES RAMP_DISTANCES REAL SLOW_COUNT SLOW_RATE"
        " SLOW_SPEED SPEED_RAMP TAIL TENS",
    ),
    "view": (
        view,
        "DECADES FILM_MARGIN LEAST_NORMAL_COMPONENT LEAST_SEEN_RADIUS LEAST_VIEW LONGEST_ARROW PIN_HEIGHT"
        " PIN_LINES ROOM_DISTANCE SAME_LENGTH WALL_DISTANCE",
    ),
    "jointStops": (joint_stops, "OPEN_ANGLE RANGE_POINTS RANGE_RADIUS RANGE_TICK"),
    "bodies": (outlines, "CARRIAGE CIRCLE_CORNERS FREE_END STOP_MARK"),
    "curves": (
        curves,
        "CLOSE_BEFORE EARLIEST_SHARE EARLY_TIMES LONG_CONTACT MOST_REFINED_IMPACTS TIMES_WITHIN_IMPACT",
    ),
    "mapColours": (map_colours, "QUANTILE_MARGIN LARGE_QUANTILE MOST_COLOURS WIDE_COLOURS"),
}
"""Name of a part of ``SHARED`` → a module, and the names of the module's constants that are in the part."""


def page_data() -> dict[str, Any]:
    """Return name of a part of ``SHARED`` → name of a constant → value, in types that JSON can hold."""
    return {
        **{part: _constants(module, names.split()) for part, (module, names) in CONSTANTS.items()},
        "names": {
            "STOPS": names.STOPS,
            "SLIDER_STOPS": {stop: stop.removeprefix("slider_") for stop in names.SLIDER_STOPS},
            "NORMALS": dict(zip(WALLS, BOX_NORMALS, strict=True)),
        },
        "degrees": {
            unit: [word, angles.degrees_pattern(unit), angles.or_degrees(unit)]
            for unit, word in angles.DEGREES.items()
        },
        "nearest": {
            "NUMBER": similar_names.NUMBER.pattern,
            "SYNONYMS": similar_names.SYNONYMS,
            "LIKE_NAME": similar_names.LIKE_NAME,
            "SAME_LAST": similar_names.SAME_LAST,
            "LIKE_LAST": similar_names.LIKE_LAST,
        },
        "units": {"PRODUCT": unit_text.PRODUCT.pattern, "SQUARE": unit_text.SQUARE.pattern},
        "impactUnits": {"AT_WALL": IMPACT_UNITS, "AT_STOP": STOP_UNITS},
        "peaks": {name: {"unit": peak.fmi_unit, "atStops": peak.at_stops} for name, peak in PEAKS.items()},
        "refusals": SENTENCES,
        "refusalRules": {
            "GIVEN": [*map(_rule_data, GIVEN_REFUSALS)],
            "FILE": [*map(_rule_data, REFUSALS)],
            "ENTRY": [*map(_rule_data, ENTRY_REFUSALS)],
            "SIGNAL": [*map(_rule_data, SIGNAL_REFUSALS)],
        },
        "laws": {
            name: {key: getattr(law, key) for key in LAW_FACTS}
            | {"lossless": law.formula == "0", "words": law_text(law), "group": law_group(law)}
            for name, law in CONTACT_LAWS.items()
        },
        "file": {
            "CORNERS": [corner_of_box(n, 1.0, 1.0) for n in range(1, chain_tables.BOX_CORNERS + 1)],
            "SHOWN": errors.SHOWN_CHARACTERS,
            "STEP_ROUND_OFF": STEP_ROUND_OFF,
        },
        "signals": {
            "REST_TOLERANCE": REST_TOLERANCE,
            "FORMS": list(FORMS),
            "SHAPES": SHAPES,
            "NUMBERS": NUMBERS,
            "TARGET_RATE": TARGET_RATE,
            "REQUIRED": {name: form.required for name, form in FORMS.items()},
            "OTHER": {name: form.optional for name, form in FORMS.items()},
            "KNOTS": {name: form.knots for name, form in FORMS.items() if form.knots}
            | {"trapezoid": TRAPEZOID_KNOTS},
        },
        "record": {"WORD": WORD, "COUNTS": COUNTS},
        "kernel": {
            "REINITIALIZE": REINITIALIZE,
            "NOT_GIVEN": NOT_GIVEN,
            "FRICTION_WITH_RIGID_WALLS": FRICTION_WITH_RIGID_WALLS,
            "PARALLEL_COSINE": PARALLEL_COSINE,
            "STARTS_INSIDE_WALL": STARTS_INSIDE_WALL,
            "STOP_CODES": STOP_CODES,
            "STATUS_TEXT": {str(status): text for status, text in STATUS_TEXT.items()},
        },
        "drawn": {"GROUPS": GROUPS},
        "contactLog": {"REALS": IMPACT_QUANTITIES},
        "packed": {"FINEST": FINEST},
        "quantities": {
            name: re.sub(r"\B(?=[A-Z])", " ", unit.quantity).lower()
            for name, unit in UNITS.items()
            if name != "1"
        },
    }


@cache
def declaration() -> str:
    """Return the line of JavaScript that declares the constant ``SHARED``."""
    return f"const SHARED = {json.dumps(page_data(), separators=(',', ':'))};"


def _rule_data(rule: RefusalRule) -> dict[str, Any]:
    """Return the data of a rule that refuses a value, with its condition and least value as syntax trees.

    Empty texts and false values are left out.
    """
    rule_data = {**rule._asdict(), "condition": tree(rule.condition), "bound": rule.least}
    rule_data["least"] = tree(rule.least) if rule.least else None
    return {name: value for name, value in rule_data.items() if value}


def _constants(module: ModuleType, constants: Iterable[str]) -> dict[str, Any]:
    return {name: _json_value(getattr(module, name)) for name in constants}


def _json_value(value: Any) -> Any:
    """Return a value in which lists replace arrays, so that JSON can hold it."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [_json_value(entry) for entry in value] if isinstance(value, list | tuple) else value
