"""Draw all charts anew from the stored figures: ``python benchmarks/charts.py``."""

from __future__ import annotations

import common  # isort: skip

import fidelity
import friction
import rest
import scaling
import stability_chart
import work_precision_chart


def main() -> None:
    """Draw them."""
    for module in (fidelity, friction, rest, scaling):
        common.picture(module.__name__, module.draw, module.SIZE)
    common.picture("work_precision", work_precision_chart.draw, work_precision_chart.SIZE)
    common.picture("stability", stability_chart.draw, stability_chart.SIZE)


if __name__ == "__main__":
    main()
