"""What the page knows of its scene: the record, where in it things are, parameters, outputs and walls.

The kernel in the page starts from this record. A parameter is set as the native FMU sets one: a number is put
in its word, and the kernel derives all else when it initializes. What the scene derives from other parameters
the page shows as it follows from them.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STATUS_TEXT
from chain_impact.results.impacts import LOG_DTYPE, NO_IMPACTS
from chain_impact.results.joint_stops import OPEN
from chain_impact.results.page.recorded import free_sides
from chain_impact.results.result import Result
from chain_impact.scene.limits import allowed
from chain_impact.scene.names import STOPS
from chain_impact.scene.scene import Scene, scene_keys, scene_to_dict
from chain_impact.variables.model import Model
from chain_impact.variables.table import MOTION, UNLESS_SET, WORD, first_word, word_index
from chain_impact.variables.variable import Item, Variable

TIMES = ("simulation.stop_time", "simulation.step_size")
"""What can be changed beside the FMU's parameters."""


def description(scene: Scene, command: Sequence[str]) -> dict[str, Any]:
    """All of it, as JSON can hold it.

    Args:
        scene: that the page shows.
        command: what comes after ``chain-impact simulate`` in the command that repeats what the page shows.
    """
    model = Model(_without_derivatives(scene))
    record = model.new_instance([])
    return {
        "name": scene.name,
        "file": scene_to_dict(scene),
        "text": scene.description,
        "command": list(command),
        "links": len(scene.chain.links),
        "pinned": scene.chain.base == "pinned",
        "wallNames": scene.wall_names,
        # at the start: the page moves those whose place is a parameter
        "walls": free_sides(scene.half_planes),
        "stops": sorted(scene.chain.joint_ranges),
        "openArc": OPEN,
        "contactPoints": scene.contact.points,
        "record": packed(record.tobytes()),
        "layout": layout(record.dtype),
        "inputs": [one.name for one in held_inputs(model)],
        "still": [one.name for one in model.inputs if one.place[0] == MOTION],
        "parameters": [
            *(parameter(model, one) for one in (*model.parameters, *held_inputs(model))),
            *times(scene),
        ],
        "columns": columns(model),
        "drawn": drawn(model),
        "rigidWithFriction": FRICTION_WITH_RIGID_WALLS,
        "statuses": {str(status): text for status, text in STATUS_TEXT.items()},
    }


def _without_derivatives(scene: Scene) -> Scene:
    """The scene whose kernel carries no derivatives, which do not change the motion."""
    return replace(scene, outputs=replace(scene.outputs, sensitivities=()))


def packed(content: bytes) -> str:
    """Bytes as text for a page: compressed, as a browser can undo it."""
    compressor = zlib.compressobj(9, wbits=-zlib.MAX_WBITS)
    return base64.b64encode(compressor.compress(content) + compressor.flush()).decode("ascii")


def layout(record: np.dtype) -> dict[str, Any]:
    """Where in the record the page reads what a run has found, counted in words."""

    def word(*place: str | int) -> int:
        return word_index(record, place)

    return {
        "status": word("statistics", "status"),
        "time": word("step", "time"),
        "impulses": word("quadrature", "wanted"),
        "loads": word("loads"),
        "finished": {
            "count": word("finished", "count"),
            "collected": word("finished", "collected"),
            "room": record["finished"]["point"].shape[0],
            "fields": {name: word("finished", name, 0) for name in LOG_DTYPE.names or ()},
        },
        "changes": word("changes", "count"),
        "active": word("touch", "active_count"),
        "statistics": {name: word("statistics", name) for name in record["statistics"].names or ()},
    }


def held_inputs(model: Model) -> list[Variable]:
    """The inputs that the page sets, each to a value for the whole run: all but motions of base and walls."""
    return [one for one in model.inputs if one.place[0] != MOTION]


def parameter(model: Model, variable: Variable) -> dict[str, Any]:
    """A parameter or an input of the FMU: its word, its range and what it means."""
    _, _, _, _, low, high, _, word = model.table_row(variable)
    return {
        "name": variable.name,
        "place": model.parameter_paths.get(variable.name),
        "word": word,
        "type": variable.type,
        "low": low,
        "high": high,
        "allowed": variable.allowed,
        "unit": variable.unit,
        "text": variable.description.partition(UNLESS_SET)[0],
        "items": [[item.name, sentence(item)] for item in variable.items],
        "start": json.loads(model.start_text(variable)),
        "derived": derived(model, variable),
    }


def derived(model: Model, variable: Variable) -> dict[str, Any] | None:
    """How the value of a parameter follows from others: their product, divided by a number; and in words.

    None if it does not, or from what the page cannot change.
    """
    if variable.rule is None:
        return None
    table = variable.name.rpartition(".")[0]
    factors = [key if "." in key else f"{table}.{key}" for key in variable.rule.factors]
    known = all(name in model.parameter_paths for name in factors)
    rule = {"factors": factors, "divisor": variable.rule.divisor, "text": UNLESS_SET + variable.rule.text}
    return rule if known else None


def sentence(item: Item) -> str:
    """What a choice is; of a contact law its range of use and its source."""
    law = CONTACT_LAWS.get(item.name)
    return f"{law.limits} {law.source}." if law else item.description


def times(scene: Scene) -> list[dict[str, Any]]:
    """The stop time and the step of the rows, which are no parameters of an FMU."""
    rules = {key: entry.metadata for key, entry in scene_keys() if key in TIMES}
    return [
        {
            "name": key,
            "place": key.split("."),
            "word": -1,
            "type": "real",
            "low": np.nextafter(0.0, 1.0),
            "high": 1e9,
            "allowed": allowed(float, rules[key]),
            "unit": rules[key]["unit"],
            "text": rules[key]["description"],
            "items": [],
            "start": scene.values[key],
        }
        for key in TIMES
    ]


def columns(model: Model) -> list[dict[str, Any]]:
    """The outputs of the FMU in its order, each a word of the record."""
    return [
        {"name": one.name, "unit": one.unit, "word": model.word(one), "integer": one.type != "real"}
        for one in model.outputs
    ]


def drawn(model: Model) -> dict[str, Any]:
    """What the page draws, as a recording has it, but the words of the record in place of the numbers."""
    first = first_word(model.layout, "output")
    words = np.arange(first, first + model.row.itemsize // WORD, dtype=np.float64)
    rows = Result(model, np.zeros(1), np.ndarray(1, model.row, words), NO_IMPACTS, statistics={})
    low, high = STOPS
    moments = {one.point: one.force for one in rows.touches if one.wall == low}
    return {
        "points": rows.points[0].astype(int).tolist(),
        "energies": {name: int(energy[0]) for name, energy in rows.energies.items()},
        "touches": [
            {
                "point": one.point,
                "wall": one.wall,
                "sign": -1 if one.wall == high else 1,
                "force": _word(moments[one.point] if one.wall == high else one.force),
                "depth": _word(one.penetration),
                "friction": _word(one.friction),
                "sticking": _word(one.sticking),
            }
            for one in rows.touches
        ],
        "loads": [
            {"joint": joint, "x": int(force[0, 0]), "y": int(force[0, 1])}
            for joint, force in rows.loads.items()
        ],
    }


def _word(numbers: np.ndarray | None) -> int | None:
    return None if numbers is None else int(numbers[0])
