"""The charts of stability.py, from its JSON: ``python benchmarks/stability_chart.py`` draws them anew."""

from __future__ import annotations

import common
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from stability import FIXED, OUTCOMES

STEPS_AT = 0.1  # restitution


def draw(page, record) -> None:
    """One map for each method: stiffness to the right, restitution upwards."""
    settings, names = record["settings"], list(OUTCOMES)
    stiffnesses, restitutions = settings["stiffnesses"], settings["restitutions"]
    panels = page.subplots(4, 4, sharex=True, sharey=True).ravel()
    for axes, method in zip(panels, settings["methods"], strict=True):
        grid = np.full((len(restitutions), len(stiffnesses)), np.nan)
        for row in record["results"]["cells"]:
            if row["method"] == method:
                place = restitutions.index(row["restitution"]), stiffnesses.index(row["stiffness"])
                grid[place] = names.index(row["outcome"])
        axes.imshow(
            grid, ListedColormap(list(OUTCOMES.values())), vmin=-0.5, vmax=len(names) - 0.5, origin="lower",
            aspect="auto",
        )  # fmt: skip
        label = f"scipy {method}" if method.isupper() or method == "Radau" or method[:2] == "RK" else method
        axes.set_title(method if method in FIXED else label, fontsize=10)
        axes.set_xticks(range(len(stiffnesses)), [f"{round(np.log10(k))}" for k in stiffnesses], fontsize=8)
        axes.set_yticks(range(len(restitutions)), [f"{e:g}" for e in restitutions], fontsize=8)
        # lines between the cells
        axes.set_xticks(np.arange(len(stiffnesses) + 1) - 0.5, minor=True)
        axes.set_yticks(np.arange(len(restitutions) + 1) - 0.5, minor=True)
        axes.grid(visible=False)
        axes.grid(which="minor", color="white", linewidth=1.0)
        axes.set_axisbelow(False)
        axes.tick_params(which="both", length=0)
    page.supxlabel("log₁₀ of the contact stiffness K [N/m^1.5]")
    page.supylabel("restitution e")
    seen = {row["outcome"] for row in record["results"]["cells"]}
    patches = [Patch(color=colour, label=name) for name, colour in OUTCOMES.items() if name in seen]
    page.legend(handles=patches, loc="outside upper center", ncols=len(patches))


def draw_steps(page, record) -> None:
    """Accepted steps of the error-controlled methods over stiffness."""
    axes = page.subplots()
    looks = {
        "ours explicit": (common.OURS, ":"),
        "ours implicit": (common.OURS, "--"),
        "ours auto": (common.OURS, "-"),
        "DOP853": ("#1f77b4", "-"),
        "RK45": ("#17a2b8", "-"),
        "LSODA": ("#2ca02c", "-"),
        "Radau": ("0.3", "-"),
        "BDF": ("0.6", "-"),
    }
    for method, (colour, line) in looks.items():
        rows = [
            row
            for row in record["results"]["cells"]
            if row["method"] == method and row["restitution"] == STEPS_AT
        ]
        label = method if method.startswith("ours") else f"scipy {method}"
        done = [(row["stiffness"], row["steps"]) for row in rows if row["outcome"] == "completed"]
        failed = [(row["stiffness"], row["steps"]) for row in rows if row["outcome"] != "completed"]
        axes.loglog(
            *zip(*(done or [(np.nan, np.nan)]), strict=True), line, marker="o", color=colour, label=label
        )
        if failed:
            axes.loglog(*zip(*failed, strict=True), linestyle="", marker="x", color=colour)
    axes.plot([], [], linestyle="", marker="x", color="black", label="stopped or failed\n(steps until then)")
    axes.set(xlabel="contact stiffness K [N/m^1.5]", ylabel="accepted steps for 3 s", title=f"e = {STEPS_AT}")
    page.legend(loc="outside right center")


if __name__ == "__main__":
    common.picture("stability", draw, (11, 9.5))
    common.picture("stability_steps", draw_steps, (8, 4.6), record="stability")
