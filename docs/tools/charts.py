"""Draw the chart of realised against prescribed restitution: ``python -m docs.tools.charts``.

The curves are free impacts of 1 kg at 1 m/s, simulated with each force law of the registry.
"""

from __future__ import annotations

import sys
from dataclasses import asdict, replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from chain_impact.kernel.forces.contact_law import ContactLaw
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.forces.lossless_contact import lossless_penetration
from chain_impact.pictures.drawing.distinct_curves import draw_band
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.law_looks import law_look
from chain_impact.pictures.drawing.legends import legend_at_foot
from chain_impact.pictures.drawing.style import DPI, STYLE
from chain_impact.scene.keys.tables import Contact
from chain_impact.scene.scene import load_scene, scene_from_dict
from chain_impact.simulation.simulate import simulate
from chain_impact.study_data.compared_impact import EXACT_LAW, LOSSLESS_LAW
from docs.tools import DOCS

PICTURE = DOCS / "images" / "restitution.png"
SAMPLES = np.linspace(0.005, 1.0, 200)
NAMED_LAWS = {
    "hunt_crossley": "much used",
    "lankarani_nikravesh": "much used",
    "flores": "much used",
    "kelvin_voigt": "much used",
    EXACT_LAW: "exact",
    "gharib_hurmuzlu": "differs most with losses",
    LOSSLESS_LAW: "no losses",
}
# [1] a run stops after a contact of LONGEST_RUN × (penetration without damping / impact speed)
LONGEST_RUN = 200.0
NO_FRICTION = {"friction": 0.0, "static_friction": 0.0}  # a free impact has no motion along the wall
HEIGHT = 1e-3  # [m] distance from the wall at the start of a free impact
# a law counts as accurate if its error is at most MOST_ERROR at all restitutions from FROM on
FROM, MOST_ERROR = 0.5, 0.05


def free_impact(contact: Contact, mass: float, speed: float) -> np.void:
    """Return the impact of a point mass [kg] at a speed [m/s] without gravity and friction.

    The result is a row of ``Result.impacts``.
    """
    link = {"length": 1.0, "mass": mass, "center_of_mass": 0.0, "inertia": 1.0}
    depth = lossless_penetration(0.5 * mass * speed**2, contact.stiffness, contact.exponent)
    stop = (2.0 * HEIGHT + LONGEST_RUN * depth) / speed
    data = {
        "name": "FreeImpact",
        "gravity": [0.0, 0.0],
        "chain": {"links": [link]},
        "box": {"y_min": 0.0},
        "contact": asdict(contact) | {"points": [0], "radius": 0.0, "wall": {}} | NO_FRICTION,
        "initial": {"position": [0.0, HEIGHT], "angles": [0.0], "velocity": [0.0, -speed]},
        "simulation": {"stop_time": stop, "step_size": stop},
    }
    impact: np.void = simulate(scene_from_dict(data, "free impact")).impacts[0]
    return impact


def curve(law: ContactLaw) -> np.ndarray:
    """Return the realised restitutions of a law for the prescribed restitutions in SAMPLES."""
    contact = replace(load_scene("four_link_box").contact, model=law.id, exponent=law.exponent or 1.5)
    impacts = (free_impact(replace(contact, restitution=float(e)), 1.0, 1.0) for e in SAMPLES)
    return np.array([impact["separation_speed"] / impact["impact_speed"] for impact in impacts])


def groups() -> dict[str, list[ContactLaw]]:
    """Return formulas → the laws with these; laws with the same formulas share a curve."""
    laws_by_formula: dict[str, list[ContactLaw]] = {}
    for law in CONTACT_LAWS.values():
        if not law.rigid:
            laws_by_formula.setdefault(f"{law.force} {law.formula}", []).append(law)
    return laws_by_formula


def look(names: list[str]) -> dict[str, object]:
    """Return the style of the curve of some laws, of which one is in NAMED_LAWS."""
    named_law = next(name for name in names if name in NAMED_LAWS)
    width, layer = (3.5, 2) if named_law == EXACT_LAW else (1.8, 3)
    return law_look(named_law) | {"linewidth": width, "zorder": layer}


def draw(path: Path) -> None:
    """Draw the realised restitution on the left, and its error on the right."""
    accurate = total = 0
    other_curves: dict[str, np.ndarray] = {}
    with mpl.rc_context(STYLE):
        page = Figure(figsize=(10.5, 4.4), dpi=DPI, layout="constrained")
        value, error = page.subplots(1, 2)
        for laws in groups().values():
            names, e_out = [law.id for law in laws], curve(laws[0])
            reason = next((f" ({NAMED_LAWS[name]})" for name in names if name in NAMED_LAWS), None)
            if reason:
                value.plot(SAMPLES, e_out, **look(names), label=", ".join(names) + reason)
                error.plot(SAMPLES, e_out - SAMPLES, **look(names))
            else:
                other_curves |= dict.fromkeys(names, e_out)
            total += len(names)
            accurate += len(names) * bool(np.abs(e_out - SAMPLES)[FROM <= SAMPLES].max() <= MOST_ERROR)
        middle = {name: float(np.interp(FROM, SAMPLES, e_out)) for name, e_out in other_curves.items()}
        ends = " to ".join(choose(middle, key=lambda name: middle[name]) for choose in (min, max))
        draw_band(
            value, SAMPLES, [*other_curves.values()], f"{len(other_curves)} others, at e = {FROM} {ends}"
        )
        draw_band(error, SAMPLES, [e_out - SAMPLES for e_out in other_curves.values()])
        value.set(
            xlabel="prescribed restitution e", ylabel="realised restitution", xlim=(0, 1), ylim=(0, 1.02)
        )
        error.set(xlabel="prescribed restitution e", ylabel="realised − prescribed", xlim=(0, 1))
        error.set(ylim=(-0.15, 0.15))
        write_headline(
            page,
            f"{accurate} of {total} laws that are a force realise e within {MOST_ERROR} from e = {FROM} on",
            "free impacts of 1 kg at 1 m/s",
        )
        legend_at_foot(page, value.get_legend_handles_labels()[0], columnspacing=2.0)
        page.savefig(path, dpi="figure")


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE)
