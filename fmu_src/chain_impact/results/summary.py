"""What happened, in some lines: of a result, as Python and notebooks show it, and of a recording."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from chain_impact.kernel.model.friction import STICKS
from chain_impact.kernel.status import OK, STATUS_TEXT
from chain_impact.results.joint_stops import at_stop, speed_unit, what
from chain_impact.results.stick_slip import place_of

if TYPE_CHECKING:
    from chain_impact.results.result import Result

LISTED = 30  # impacts in a notebook
SHOWN = 3  # contacts and joints that stick at the end


def plural(count: int, what: str) -> str:
    """For example: 1 impact, 2 impacts."""
    return f"{count} {what}{'s' if count != 1 else ''}"


def energy_lines(columns: Mapping[str, np.ndarray]) -> Iterator[str]:
    """The energies at the end, and how far they were out of balance; nothing if there are no such columns."""
    if not {"energy.total", "energy.dissipated"} <= columns.keys():
        return
    total, dissipated = columns["energy.total"], columns["energy.dissipated"]
    supplied = columns.get("energy.supplied", 0.0 * total)
    balance = total + dissipated - supplied
    given = f" + {supplied[-1]:.6g} J supplied" if supplied.any() else ""
    rest = f"{total[-1]:.6g} J left + {dissipated[-1]:.6g} J dissipated"
    yield f"energy   {total[0]:.6g} J at the start{given} = {rest}"
    yield f"balance  off by at most {abs(balance - balance[0]).max():.1e} J, the error of the solver"


def text(result: Result) -> str:
    """A result in a few lines."""
    return "\n".join([_headline(result), *_impact_lines(result), *_friction_lines(result), *_facts(result)])


def html(result: Result) -> str:
    """A result for a notebook: with a table of its impacts."""
    head = "".join(f"<th>{name}</th>" for name in ("", "time, s", "point", "wall", _speed_head(result)))
    rows = [
        "".join(f"<td>{escape(cell)}</td>" for cell in (str(number), *_cells(result, impact)))
        for number, impact in enumerate(result.impacts[:LISTED], 1)
    ]
    more = len(result.impacts) - LISTED
    table = f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>" if rows else ""
    table += f"<p>… and {plural(more, 'more impact')}</p>" if more > 0 else ""
    facts = "\n".join(map(escape, [*_friction_lines(result), *_facts(result)]))
    return f"<div><b>{escape(_headline(result))}</b>{table}<pre>{facts}</pre></div>"


def _headline(result: Result) -> str:
    end = f"{result.time[-1]:g}" if len(result.time) else "0"
    rows = f"{plural(len(result.time), 'row')} of {plural(len(result.names), 'output')}"
    return f"{result.scene.name}  0 … {end} s, {plural(len(result.impacts), 'impact')}, {rows}"


def _impact_lines(result: Result) -> Iterator[str]:
    ends = {"first": result.impacts[:1], "last": result.impacts[1:][-1:]}
    for word, rows in ends.items():
        for row in rows:
            time, _, wall, speed = _cells(result, row)
            stop = at_stop(result.scene, row["wall"])
            hit = f"{what(row['point'], stop)} hits {wall} at {speed.split()[0]} {speed_unit(stop)}"
            yield f"{word:9}impact at {time} s: {hit}"


def _friction_lines(result: Result) -> Iterator[str]:
    """How many phases of dry friction there were, and what sticks at the end."""
    phases = result.stick_slip
    if not len(phases):
        return
    sticking = int((phases["mode"] == STICKS).sum())
    yield f"friction {plural(sticking, 'phase')} of sticking, {len(phases) - sticking} of sliding"
    last = phases[np.isnan(phases["end"]) & (phases["mode"] == STICKS)]
    places = [f"{place_of(one, result.scene.wall_names)} since {one['start']:.6f} s" for one in last]
    if places:
        more = [f"{len(places) - SHOWN} more"] if len(places) > SHOWN else []
        yield f"{'':9}sticks at the end: {', '.join([*places[:SHOWN], *more])}"


def _cells(result: Result, impact: np.void) -> tuple[str, str, str, str]:
    wall, stop = result.scene.wall_names[impact["wall"]], at_stop(result.scene, impact["wall"])
    point = what(impact["point"], True) if stop else str(impact["point"])
    unit = f" {speed_unit(stop)}" if result.scene.chain.stops else ""
    return f"{impact['onset']:.6f}", point, wall, f"{impact['impact_speed']:.4f}{unit}"


def _speed_head(result: Result) -> str:
    """The head of the column of speeds: with the unit, where all speeds have the same."""
    return "speed" if result.scene.chain.stops else "speed, m/s"


def _facts(result: Result) -> Iterator[str]:
    yield from energy_lines(result.motion if len(result.time) else {})
    yield from (f"note     {hint}" for hint in hints(result))
    counts = result.statistics
    steps = f"{counts['steps']} steps, of which {counts['implicit_steps']} implicit"
    yield f"solver   {steps}; {counts['rhs_evaluations']} evaluations of the equations of motion"
    status = counts["status"]
    yield f"status   {status}: {'done' if status == OK else STATUS_TEXT[status]}"


def hints(result: Result) -> list[str]:
    """A sentence on a wall that gives way by more than the length of the shortest link, and so is no wall.

    It names the wall beyond which a point went farthest. A chain of one link that touches with one point is a
    ball: the length of its link means nothing.
    """
    scene, links = result.scene, result.scene.chain.links
    if len(links) == len(scene.contact.points) == 1:
        return []
    walls = [number for number in range(len(scene.wall_names)) if not at_stop(scene, number)]
    depths = np.where(np.isin(result.impacts["wall"], walls), result.impacts["max_penetration"], 0.0)
    shortest = min(link.length for link in links)
    if depths.max(initial=0.0) <= shortest:
        return []
    wall = scene.wall_names[result.impacts["wall"][depths.argmax()]]
    material = scene.contact.wall.get(wall)
    own = material.stiffness if material else None
    name, stiffness = ("contact", scene.contact.stiffness) if own is None else (f"wall.{wall}", own)
    return [
        f"a point goes farther beyond {wall} than the shortest link is long, {shortest:g} m: "
        f"{name}.stiffness = {stiffness:g} [N/m^{scene.contact.exponent:g}] is small for this motion"
    ]


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """The lines of a table; its columns are as wide as they need to be."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    for row in (head, *rows):
        yield "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
