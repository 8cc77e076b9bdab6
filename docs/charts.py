"""Draw the chart of realised against prescribed restitution: ``python docs/charts.py``.

The curves are free impacts of 1 kg at 1 m/s, simulated with each law of the registry that is a force.
"""

from __future__ import annotations

import itertools
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.laws.registry import ContactLaw
from chain_impact.scene import load_scene
from chain_impact.studies.compare import free_impact

PICTURE = Path(__file__).parent / "images" / "restitution.png"
SAMPLES = np.linspace(0.005, 1.0, 200)
STYLE = {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False}
EXACT = "zhang_sharf"
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)))


def curve(law: ContactLaw) -> np.ndarray:
    """Realised restitution of a law over SAMPLES."""
    contact = replace(load_scene("four_link_box").contact, model=law.id, exponent=law.exponent or 1.5)
    impacts = (free_impact(replace(contact, restitution=float(e)), 1.0, 1.0) for e in SAMPLES)
    return np.array([impact["separation_speed"] / impact["impact_speed"] for impact in impacts])


def groups() -> dict[str, list[ContactLaw]]:
    """Laws with the same force and factor f(e), by their formulas: they share a curve."""
    found: dict[str, list[ContactLaw]] = {}
    for law in CONTACT_LAWS.values():
        if not law.impulsive:
            found.setdefault(f"{law.force} {law.formula}", []).append(law)
    return found


def draw(path: Path) -> None:
    """Realised restitution on the left, its error on the right."""
    with mpl.rc_context(STYLE):
        page = Figure(figsize=(12.4, 4.7), layout="constrained")
        value, error = page.subplots(1, 2)
        styles = itertools.product(LINES, colormaps["tab10"].colors)
        for laws in groups().values():
            exact = laws[0].id == EXACT
            line, colour = ("-", "0.75") if exact else next(styles)
            look = {"color": colour, "linestyle": line, "linewidth": 6.0 if exact else 1.7}
            look["zorder"] = 1 if exact else 2
            label = ", ".join(law.id for law in laws) + (" (exact)" if exact else "")
            e_out = curve(laws[0])
            value.plot(SAMPLES, e_out, label=label, **look)
            error.plot(SAMPLES, e_out - SAMPLES, **look)
        value.set(
            xlabel="prescribed restitution e", ylabel="realised restitution e′", xlim=(0, 1), ylim=(0, 1.02)
        )
        error.set(xlabel="prescribed restitution e", ylabel="error e′ − e", xlim=(0, 1), ylim=(-0.15, 0.15))
        for axes in (value, error):
            axes.set_box_aspect(1)
        page.legend(loc="outside right upper", fontsize=9)
        page.savefig(path, dpi=120)


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE)
