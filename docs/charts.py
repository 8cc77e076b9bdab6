"""Draw the chart of realised against prescribed restitution: ``python docs/charts.py``.

The curves come from the registry of contact laws and the exact relation of docs/contact_laws.md.
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from scipy.special import lambertw

from chain_impact.kernel.contact_laws import CONTACT_LAWS, ContactLaw

PICTURE = Path(__file__).parent / "images" / "restitution.png"
SAMPLES = np.linspace(0.005, 1.0, 400)
STYLE = {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False}
EXACT = "zhang_sharf"
COLOURS = (*colormaps["tab10"].colors, "black")


def realised(factor: float) -> float:
    """The restitution e′ of F = K δⁿ (1 + λ δ̇/v₀): [1 + W₀(−(1+λ) e^{−(1+λ)})]/λ."""
    if factor == 0.0:
        return 1.0
    return float((1.0 + lambertw(-(1.0 + factor) * np.exp(-(1.0 + factor))).real) / factor)


def curve(law: ContactLaw) -> np.ndarray:
    """Realised restitution of a law over SAMPLES."""
    return np.array([realised(law.damping_factor(float(e))) for e in SAMPLES])


def groups() -> dict[str, list[ContactLaw]]:
    """Laws with the same λ(e), by their formula: they share a curve."""
    found: dict[str, list[ContactLaw]] = {}
    for law in CONTACT_LAWS.values():
        if law.impulsive:
            continue
        found.setdefault(law.formula, []).append(law)
    return found


def draw(path: Path) -> None:
    """Realised restitution on the left, its error on the right."""
    with mpl.rc_context(STYLE):
        page = Figure(figsize=(12.4, 4.7), layout="constrained")
        value, error = page.subplots(1, 2)
        colours = iter(zip(COLOURS, itertools.cycle(["-", (0, (6, 1.5))])))
        for laws in groups().values():
            exact = laws[0].id == EXACT
            colour, line = ("0.75", "-") if exact else next(colours)
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
