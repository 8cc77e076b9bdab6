"""The numbers at axes and in texts: the distances of ticks, the units of forces, raised exponents."""

from __future__ import annotations

import re

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import AutoLocator, EngFormatter, FuncFormatter, MaxNLocator

from chain_impact.text import LOAD_UNITS, prefixed_unit

LEAST_LOAD = 0.1  # a value below this in a unit of LOAD_UNITS gets a prefix, such as mN
LEAST_TICKS = 3  # the least number of ticks on an axis
TICK_STEPS = (1, 2, 2.5, 5, 10)  # the allowed distances between ticks, times any power of ten
# the allowed distances between ticks on an axis of counts, times any power of ten
COUNT_STEPS = (1, 2, 5, 10)


def give_ticks(*axes: Axes) -> None:
    """Give each linear axis x or y that has matplotlib's own ticks at least LEAST_TICKS ticks."""
    for panel in axes:
        for axis in (panel.xaxis, panel.yaxis):
            if axis.get_scale() == "linear" and isinstance(axis.get_major_locator(), AutoLocator):
                axis.set_major_locator(MaxNLocator("auto", steps=list(TICK_STEPS), min_n_ticks=LEAST_TICKS))


def scale_numbers(axis: Axis, factor: float) -> None:
    """Write the values at the ticks of an axis times ``factor``; the caller writes the unit of the result."""
    if factor != 1.0:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{factor * value:.10g}".replace("-", "−")))


def load_unit(largest_load: float, unit: str) -> tuple[float, str]:
    """Return ``prefixed_unit``, in which a unit of LOAD_UNITS stays for LEAST_LOAD ≤ ``largest_load`` < 1."""
    is_load = unit.replace("·", ".") in LOAD_UNITS
    return (1.0, unit) if is_load and LEAST_LOAD <= largest_load < 1.0 else prefixed_unit(largest_load, unit)


def force_text(value: float, unit: str) -> str:
    """Return a value > 0, in three digits at most, in the unit of ``load_unit``: "12.3 kN", "0.5 N"."""
    value = float(f"{value:.3g}")  # 9.999 is 10.0, not 10.00
    if value < 1.0 and load_unit(value, unit)[1] == unit:
        return f"{value:.3g} {unit}"
    return EngFormatter(unit, places=2 - int(np.floor(np.log10(value))) % 3)(value)


def raise_exponents(text: str) -> str:
    """Return a text for matplotlib in which exponents after ``^`` are raised: N/m$^{1.5}$ for N/m^1.5."""
    return re.sub(r"\^([\d.]+|[a-z]+)", r"$^{\1}$", text)
