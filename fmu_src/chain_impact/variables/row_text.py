"""Reads the rows of a table of variables from text: one row for each kind; kind.py explains the attributes.

The cells of a row are the name without the prefix, the unit, the description, and attributes. Attributes are
those of ``Kind``, and ``field``: the path of the field in its part of the record, if not the row's name.
Rows of inputs lack name and unit, which the argument ``names`` of ``rows_block`` has. A row with {axis}
stands for two rows: for x, where {j} is 0, and for y, where {j} is 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from chain_impact.scene.words.names import AXES, INDEX_PLACE
from chain_impact.variables.kind import NEXT, Block, Kind, block


def rows_block(
    *,
    part: str,
    owner_kind: str,
    prefix: str,
    rows: str,
    names: Mapping[str, str] = MappingProxyType({}),
    array: bool = False,
    **other: Any,
) -> Block:
    """Return a block of kinds whose values are in one part of the record.

    Args:
        part: the part of the record.
        owner_kind: the kind of owner.
        prefix: the first part of the names.
        rows: the rows of the table. ``{at}``, the index of the owner, is appended to the path of a field that
            has neither ``{at}`` nor ``{next}``, unless ``owner_kind`` is "one" or "slider".
        names: whole name → unit, for rows that lack name and unit: row k has the k-th name that begins with
            ``prefix``.
        array: whether the values of all owners form an array with the name <owner_kind>.<name in the row>.
        other: attributes that all kinds have, and further arguments of ``block``.
    """
    kinds, head = list[Kind](), f"{prefix}."
    given = [(name.removeprefix(head), unit) for name, unit in names.items() if name.startswith(head)]
    for number, (axis, cells) in enumerate(_rows(rows)):
        row_cells = (*given[number], *cells) if given else cells
        try:
            kinds.append(_kind(part, owner_kind, axis, array, row_cells))
        except (TypeError, ValueError) as error:
            raise ValueError(
                f"the row {' | '.join(row_cells)!r} of {prefix or part} is wrong: {error}"
            ) from None
    return block(owner_kind, *kinds, prefix=prefix, **{"is_terminal": True} | other)


def _kind(part: str, owner_kind: str, axis: str, array: bool, cells: Sequence[str]) -> Kind:
    """Return the kind that the cells of one row describe; wrong cells raise TypeError or ValueError."""
    name, unit, text, *more = cells
    attributes: dict[str, Any] = {"array": f"{owner_kind}.{name}" if array else "", "field": name}
    attributes |= dict(_attribute(attribute, unit) for cell in more for attribute in cell.split())
    name, field = (template.replace("{axis}", axis) for template in (name, attributes.pop("field")))
    steps = [int(step) if step.isdecimal() else step for step in field.split(".")]
    index = [] if owner_kind in ("one", "slider") or INDEX_PLACE in steps or NEXT in steps else [INDEX_PLACE]
    path = (part, *steps, *index)
    return Kind(name=name, unit=unit, text=text, record_path=path, axis=axis, **attributes)


def _rows(text: str) -> Iterator[tuple[str, list[str]]]:
    """Yield (axis, cells) for each row of the table ``text``.

    A row with {axis} is yielded for x and for y; the axis of any other row is "".
    """
    for line in text.strip().splitlines():
        for j, axis in enumerate(AXES if "{axis}" in line else ("",)):
            yield axis, [cell.strip().replace("{j}", str(j)) for cell in line.split("|")]


def _attribute(text: str, unit: str) -> tuple[str, Any]:
    """Return the name and value of an attribute that a row has as text, such as ``minimum=0``.

    An attribute without "=" has the value True. The value of ``minimum`` or ``maximum`` is the name of a
    number, or a float if the row has a ``unit``, else an int; that of ``when`` is a tuple; others are texts.
    """
    name, _, value = text.partition("=")
    if name == "when":
        return name, (value,)
    if name in ("minimum", "maximum") and not value.isidentifier():
        return name, float(value) if unit else int(value)
    return name, value or True
