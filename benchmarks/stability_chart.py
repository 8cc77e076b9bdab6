"""The chart of stability.py."""

from __future__ import annotations

import numpy as np
from looks import INK, headline
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

ADAPTIVE = ("RK45", "DOP853", "Radau", "BDF", "LSODA")
METHODS = ("explicit", "implicit", "auto")
SIZE = (9.5, 8.6)  # inches
LEVELS = (1e-3, 1e-2, 1e-1, 1.0)  # errors of the energy, parts of that at the start, where the colour changes
NAMES = ("below 0.1 %", "to 1 %", "to 10 %", "to 100 %", "more")
SHADES = ListedColormap(colormaps["cividis_r"](np.linspace(0.05, 1.0, len(NAMES))))
LATE = {"marker": "s", "markersize": 3.5, "markerfacecolor": "none", "linestyle": ""}
FAULTY = {"marker": "x", "markersize": 4.0, "markeredgewidth": 1.1, "linestyle": ""}


def title_of(method: str) -> str:
    """A method's name in the chart."""
    return f"scipy {method}" if method in ADAPTIVE else method.replace("ours auto", "chain-impact")


def completed(record, method: str) -> int:
    """How many cells of a method were completed."""
    rows = record["results"]["cells"]
    return sum((row["method"], row["outcome"]) == (method, "completed") for row in rows)


def expected_energy(record) -> dict[tuple[float, float], float]:
    """The energy at the end by stiffness and restitution, as a part of that at the start.

    The median of the methods that control their error; those that did not complete are left out.
    """
    controlled = (*(f"ours {method}" for method in METHODS), *ADAPTIVE)
    found: dict[tuple[float, float], list[float]] = {}
    for row in record["results"]["cells"]:
        if row["method"] in controlled and row["outcome"] == "completed":
            found.setdefault((row["stiffness"], row["restitution"]), []).append(row["energy_left"])
    return {place: float(np.median(values)) for place, values in found.items()}


def energy_errors(record, method: str) -> np.ndarray:
    """Errors of the energy at the end, restitution by stiffness; infinite where it is not finite."""
    settings, expected = record["settings"], expected_energy(record)
    errors = np.full((len(settings["restitutions"]), len(settings["stiffnesses"])), np.nan)
    for row in (row for row in record["results"]["cells"] if row["method"] == method):
        left = row.get("energy_left")
        error = np.inf if left is None else abs(left - expected[row["stiffness"], row["restitution"]])
        errors[place_of(record, row)] = error if np.isfinite(error) else np.inf
    return errors


def place_of(record, row) -> tuple[int, int]:
    """Line and column of a cell."""
    settings = record["settings"]
    return settings["restitutions"].index(row["restitution"]), settings["stiffnesses"].index(row["stiffness"])


def draw(page, record) -> None:
    """One map for each method: stiffness to the right, restitution upwards, coloured by the error."""
    settings = record["settings"]
    stiffnesses, restitutions = settings["stiffnesses"], settings["restitutions"]
    done = {method: completed(record, method) for method in settings["methods"]}
    cells = len(stiffnesses) * len(restitutions)
    full = [title_of(method) for method in ("ours auto", *ADAPTIVE) if done[method] == cells]
    headline(
        page,
        f"{', '.join(full)} complete all {cells} cells, RK4 with steps of 1 ms only {done['RK4 0.001 s']}",
        f"a rod falls, clatters and settles in {settings['stop [s]']:g} s  ·  colour: error of the energy at "
        "the end, as a part of that at the start  ·  counts: completed cells",
    )
    panels = page.subplots(4, 4, sharex=True, sharey=True).ravel()
    norm = BoundaryNorm([-1.0, *LEVELS, np.inf], SHADES.N)
    for axes, method in zip(panels, settings["methods"], strict=True):
        rows = [row for row in record["results"]["cells"] if row["method"] == method]
        errors = energy_errors(record, method)
        for row in (row for row in rows if row["outcome"] != "completed"):
            line, column = place_of(record, row)
            mark = LATE if row["outcome"] == "over budget" else FAULTY
            dark = mark == FAULTY and errors[line, column] > LEVELS[1]
            errors[line, column] = np.nan if mark == LATE else errors[line, column]
            axes.plot(column, line, color="white" if dark else INK, **mark)
        axes.imshow(np.minimum(errors, 1e9), SHADES, norm, origin="lower", aspect="auto")
        axes.set_title(
            f"{title_of(method)}: {done[method]} of {cells}",
            fontsize=9,
            fontweight="bold" if done[method] == cells else None,
        )
        axes.set_xticks(range(len(stiffnesses)), [f"{round(np.log10(k))}" for k in stiffnesses], fontsize=7.5)
        axes.set_yticks(range(len(restitutions)), [f"{e:g}" for e in restitutions], fontsize=7.5)
        # lines between the cells
        axes.set_xticks(np.arange(len(stiffnesses) + 1) - 0.5, minor=True)
        axes.set_yticks(np.arange(len(restitutions) + 1) - 0.5, minor=True)
        axes.grid(visible=False)
        axes.grid(which="minor", color="white", linewidth=1.0)
        axes.set_axisbelow(False)
        axes.tick_params(which="both", length=0)
    for axes in panels[-4:]:
        axes.set_xlabel("log₁₀ of K [N/m$^{1.5}$]")
    for axes in panels[::4]:
        axes.set_ylabel("restitution e")
    keys = [Patch(color=SHADES(level), label=name) for level, name in enumerate(NAMES)]
    late = f"not done in {settings['budget [s CPU]']:g} s of CPU time"
    keys.append(Line2D([], [], color=INK, label=late, **LATE))
    keys.append(Line2D([], [], color=INK, label="gained energy or tunnelled", **FAULTY))
    page.legend(handles=keys, loc="outside lower center", ncols=len(keys), columnspacing=1.2)
