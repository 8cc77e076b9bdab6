"""Draw all charts anew from the stored figures: ``python benchmarks/charts.py``."""

from __future__ import annotations

import common  # isort: skip

import fidelity
import friction
import rest
import rhs
import scaling
import stability_chart
import stiffness
import work_precision_chart


def main() -> None:
    """Draw them."""
    for module in (fidelity, friction, rest, rhs, scaling, stiffness):
        common.picture(module.__name__, module.draw, module.SIZE)
    work_precision_chart.draw_all()
    stability_chart.draw_all()


if __name__ == "__main__":
    main()
