"""The table of impacts: its columns, and its computation from the outputs of an FMU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import count as naturals
from typing import Any

import numpy as np

from chain_impact.kernel.record.constants import WALLS
from chain_impact.kernel.record.contacts import contact_log_dtype
from chain_impact.scene.texts.names import SLIDER_STOPS, STOPS, name_parts
from chain_impact.scene.warning import warn
from chain_impact.variables.outputs import OUTPUTS

_LOG = contact_log_dtype(0)
# fields of the kernel's log of contacts that are not columns of the table of impacts
_LOG_BOOKKEEPING = ("count", "collected", "impact_number")
LOG_DTYPE = np.dtype([(name, _LOG[name].base) for name in _LOG.names or () if name not in _LOG_BOOKKEEPING])
"""The columns of ``IMPACT_DTYPE`` that the kernel's log of contacts has, too: all but the name of the wall
and the duration."""
IMPACT_DTYPE = np.dtype(
    [
        *((name, LOG_DTYPE[name]) for name in LOG_DTYPE.names or ()),
        ("wall_name", "U32"),
        ("duration", np.float64),
    ]
)
"""The columns of the table of impacts; each row is one contact.

- ``point``: the number of the point
- ``wall``: the index of the wall in ``scene.wall_names``
- ``onset``, ``end``: the times at which the contact begins and ends [s]
- ``impact_speed``, ``separation_speed``: the speeds toward the wall at the onset and away from it at the end
  [m/s]
- ``peak_force``: the largest force of the wall [N]
- ``max_penetration``: the largest penetration [m]
- ``effective_mass``: the effective mass at the onset [kg]
- ``impulse``: the impulse of the wall [N·s], as accurate as the momentum of the chain
- ``joint_force``: the largest force in any joint during the contact [N]
- ``joint``: the number of this joint, 1…N
- ``x``, ``y``: the position at which the point touches at the onset [m]
- ``wall_name``: the first 32 characters of the wall's name
- ``duration``: end − onset [s]

If the scene asks for no impulses, the impulse is NaN. If the scene asks for no loads, the force in a joint is
NaN, and the number of the joint is 0. If the wall's name is unknown, it is "". If a contact lasts to the end
of the simulation, its end, duration and separation speed are NaN.

Under the law ``newton_impact``, a bounce has the duration 0. Its peak force, the force in a joint (NaN
without loads) and the number of the joint are 0. The output ``joint[i].impulse`` jumps by the impulse that it
causes in joint i. For a contact with a duration, the forces are the largest ones during the contact, as under
the other laws.

At a stop of a joint, the wall is ``joint_min`` or ``joint_max``, and the point is the number of the joint,
1…N. The quantities then belong to the joint's angle: speeds [rad/s], moment [N·m], angle beyond the stop
[rad], effective inertia [kg·m²], impulse of the moment [N·m·s]. At a stop of a slider, the wall is
``slider_min`` or ``slider_max``, the point is 0, and the units are those of a wall. The position is
that of the joint or, at a stop of a slider, of the base."""

NO_IMPACTS = np.zeros(0, IMPACT_DTYPE)
NO_IMPACTS.flags.writeable = False
FMU_NAMES = {
    str(kind.record_path[1]): kind.parts.quantity
    for block in OUTPUTS
    for kind in block.kinds
    if kind.owner_kind == "impact"
}
"""Column of the table of impacts → the last part of the name of its variable in FMUs, `impact[1].time`."""
POSITION = ("x", "y")
UNSHOWN_COLUMNS = ("effective_mass", "joint_force", *POSITION)
"""The columns that are NaN in a table from an FMU's outputs, because the FMU has no outputs for them."""


def impact_table_of_log(impacts: np.ndarray, walls: Sequence[str]) -> np.ndarray:
    """Return the impacts of a log of contacts as a table with the names of their walls and the durations.

    ``walls`` has the names, in the order of the walls' numbers.
    """
    table = np.zeros(len(impacts), IMPACT_DTYPE)
    # the columns are copied as plain numbers, because NumPy copies tables of columns much more slowly
    _numbers(table)[:, : len(LOG_DTYPE.names or ())] = _numbers(impacts)
    table["wall_name"] = _names(tuple(walls)).take(impacts["wall"] + 1, mode="clip")
    table["duration"] = impacts["end"] - impacts["onset"]
    return table


@lru_cache(100)
def _names(walls: tuple[str, ...]) -> np.ndarray:
    """Return the names of walls and stops between two empty names, one in front and one at the end.

    So an impact gets the name "" if the number of its wall is −1, or larger than that of any wall or stop.
    """
    return np.array(["", *walls, ""], IMPACT_DTYPE["wall_name"])


def sorted_impacts(parts: Sequence[np.ndarray], walls: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Join logs of contacts; return the indices that sort their joined rows, and the sorted table of impacts.

    The order is by onset; at the same onset, by point and then wall.
    """
    filled_parts = [_numbers(part) for part in parts if len(part)] or [_numbers(parts[0])]
    # most runs have one log with contacts, which needs no copy
    numbers = filled_parts[0] if len(filled_parts) == 1 else np.concatenate(filled_parts)
    ordered_impacts = np.ndarray(len(numbers), LOG_DTYPE, numbers)
    order = np.lexsort((ordered_impacts["wall"], ordered_impacts["point"], ordered_impacts["onset"]))
    return order, impact_table_of_log(np.ndarray(len(numbers), LOG_DTYPE, numbers.take(order, 0)), walls)


def _numbers(table: np.ndarray) -> np.ndarray:
    """Return a table as rows of 8-byte numbers, which NumPy copies fast; integers keep their bits, too."""
    return np.ndarray((len(table), table.itemsize // 8), np.float64, table)


def common_count(first_impacts: np.ndarray, second_impacts: np.ndarray) -> int:
    """Return for how many rows, from the first one on, two tables of impacts have equal points and walls."""
    pairs = [[(row["point"], row["wall"]) for row in table] for table in (first_impacts, second_impacts)]
    different_rows = (
        k for k, (pair, other_pair) in enumerate(zip(*pairs, strict=False)) if pair != other_pair
    )
    return next(different_rows, min(map(len, pairs)))


def lasts_to_end(impacts: np.ndarray | np.void) -> Any:
    """Return for each contact whether it lasts to the end of the simulation.

    The end of such a contact is NaN, but its peak force is known. If the peak force is NaN, too, the outputs
    of an FMU do not tell the end; then the result is False.
    """
    return np.isnan(impacts["end"]) & ~np.isnan(impacts["peak_force"])


def impacts_of(record: Mapping[str, Any] | np.ndarray | Any, walls: Sequence[str] = ()) -> np.ndarray:
    """Compute the table of impacts from a record of the FMU's outputs over time.

    An FMU shows its latest impacts at each communication point, in the outputs `impact[1].time` and so on.
    The key `outputs.impacts` of the scene tells how many impacts the FMU shows. The table is complete if no
    communication step has more new impacts than this number. A ``SceneWarning`` tells if impacts are missing,
    or if newer impacts pushed a contact out of the FMU's list before its end.

    Args:
        record: columns of values over time, each of shape (T,), by their names: a mapping, a structured array
            such as fmpy returns, or a data frame. The columns are `time`, `impact.count` and `impact[j].*`, j
            = 1 … M. It may also be a `Result`, whose table is returned.
        walls: the names of all walls by their numbers, `scene.wall_names`; by default those of the box, then
            the other names in the columns of contacts and stops.

    Returns:
        A structured array as `Result.impacts`, in order of onset, see `IMPACT_DTYPE`. The effective mass,
            the position and the force in a joint are NaN, and the number of the joint is 0, because an FMU
            has no outputs for them. If a contact lasts to the end of the record, or if newer impacts push it
            out of the FMU's list before it ends, its end and its separation speed are NaN. In the second
            case, its peak force, penetration and impulse are NaN, too.

    Raises:
        ValueError: when a column is missing, or the record has no rows.
    """
    stored_impacts = getattr(record, "impacts", None)
    if isinstance(stored_impacts, np.ndarray) and stored_impacts.dtype == IMPACT_DTYPE:
        return stored_impacts
    table = _table(record, walls)
    count, cut_count = int(_column(record, "impact.count")[-1]), int(np.isnan(table["peak_force"]).sum())
    sentences = []
    if len(table) < count:
        sentences.append(
            f"{count - len(table)} of {count} impacts are missing, as a communication step has more than the "
            "FMU shows: give the scene a larger outputs.impacts, or take shorter steps"
        )
    warn("impacts_of", [*sentences, *([cut_sentence(cut_count)] if cut_count else [])])
    return table


def cut_sentence(count: int) -> str:
    """Return the warning for ``count`` contacts that newer impacts have pushed out of an FMU's list."""
    cut_text = (
        "contact is known in part only: it was"
        if count == 1
        else "contacts are known in part only: they were"
    )
    return (
        f"{count} {cut_text} still going on when newer impacts filled the FMU's list, so peak force, "
        "penetration and impulse are NaN; give the scene a larger outputs.impacts"
    )


def _table(record: Any, walls: Sequence[str]) -> np.ndarray:
    """Return the table of those impacts that the columns `impact[j].*` of an FMU's outputs over time show."""
    time, counts = _column(record, "time"), _column(record, "impact.count").astype(np.int64)
    shown_count = next(j for j in naturals(1) if f"impact[{j}].time" not in names_of(record)) - 1
    if len(time) == 0:
        raise ValueError("the record has no rows")
    if shown_count == 0:
        raise ValueError("there is no column impact[1].time: the scene has outputs.impacts = 0")
    number = np.arange(1, counts[-1] + 1)
    # ``number`` is k for impact k of the run. An FMU that has counted ``count`` impacts shows impact k as
    # impact[j], j = count − k + 1. ``row`` is the last row in which it shows impact k.
    row = np.searchsorted(counts, number + shown_count - 1, side="right") - 1
    is_seen = counts[row] >= number
    number, row = number[is_seen], row[is_seen]
    table = np.zeros(len(number), LOG_DTYPE)
    for field in UNSHOWN_COLUMNS:
        table[field] = np.nan
    for field, name in FMU_NAMES.items():
        columns = np.array([_column(record, f"impact[{j}].{name}") for j in range(1, shown_count + 1)])
        table[field] = columns[counts[row] - number, row]
    table["wall"] -= 1
    is_lasting = (table["end"] == time[row]) & (table["end"] > table["onset"])
    for field in ("end", "separation_speed"):
        table[field][is_lasting] = np.nan
    # the final values of a contact that newer impacts have pushed out of the FMU's list are unknown
    for field in ("peak_force", "max_penetration", "impulse"):
        table[field][is_lasting & (row < len(time) - 1)] = np.nan
    return impact_table_of_log(
        np.sort(table, order=["onset", "point", "wall"]), walls or wall_names_of(record)
    )


def wall_names_of(record: Any) -> list[str]:
    """Return the names of walls and stops by their numbers, as far as columns tell them.

    The walls of the box come first, then other walls in columns of contacts, stops of joints, stops of a
    slider. Without columns of contacts at walls, the numbers of the stops of joints are unknown, and these
    stops are left out.
    """
    names = [name_parts(str(name)) for name in names_of(record)]
    touched_names = [parts.name for parts in names if parts.owner == "contact" and parts.quantity == "force"]
    ends = [stop for stop in SLIDER_STOPS if stop in touched_names]
    touched_names = [name for name in touched_names if name not in ends]
    stops = STOPS if touched_names and any(parts.quantity == "stop_moment" for parts in names) else ()
    return [*dict.fromkeys((*WALLS, *touched_names)), *stops, *ends]


def shown_impacts(record: Any, walls: Sequence[str] = ()) -> np.ndarray:
    """Return the impacts that an FMU's outputs show, also if the FMU has no list: see `IMPACT_DTYPE`.

    ``walls`` has the names of all walls by their numbers; without it, the names are those of
    ``wall_names_of`` or, if the FMU has no list, "". An FMU with `outputs.impacts = 0` has no list. Its
    outputs show only the last impact of each communication step. Only the point, the wall, the onset and the
    impact speed of this impact are then known; the number of the joint is 0, all other values are NaN.
    """
    if "impact[1].time" in names_of(record):
        return _table(record, walls)
    rows = np.flatnonzero(np.diff(record["impact.count"], prepend=0))
    table = np.full(len(rows), np.nan, np.dtype([(name, np.float64) for name in LOG_DTYPE.names or ()]))
    for field in ("point", "wall", "onset", "impact_speed"):
        table[field] = np.asarray(record[f"impact.last_{FMU_NAMES[field]}"])[rows]
    table["wall"] -= 1
    table["joint"] = 0
    return impact_table_of_log(table.astype(LOG_DTYPE), walls)


def names_of(record: Any) -> Any:
    """Return the names of the columns of a structured array, a mapping or a data frame."""
    dtype = getattr(record, "dtype", None)
    return dtype.names if dtype is not None and dtype.names else record.keys()


def _column(record: Any, name: str) -> np.ndarray:
    if name not in names_of(record):
        raise ValueError(f"the record has no column {name}")
    return np.asarray(record[name])
