"""Pictures of sweeps of the four-link box, for the tests of their parts."""

from functools import partial

from matplotlib.figure import Figure

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.pictures.sweep.layout import usual_sweep_size
from chain_impact.pictures.sweep.plot import draw_sweep, headline_and_conditions
from chain_impact.pictures.sweep.quantities import shown_quantities_of
from chain_impact.scene.scene import load_scene

SCENE = load_scene("four_link_box").with_values({"simulation.stop_time": 0.6, "solver.tolerance": 1e-6})
TEN = [law for law in CONTACT_LAWS if law not in ("kelvin_voigt", "newton_impact", "ye")][:10]


def sweep_page(runs):
    shown_quantities = shown_quantities_of(runs)
    page = Figure(
        figsize=usual_sweep_size(runs.design, len(shown_quantities.drawn_quantities)), layout="constrained"
    )
    draw_sweep(page, runs, shown_quantities, partial(headline_and_conditions, runs, shown_quantities))
    page.draw_without_rendering()
    return page


def labels_of(page):
    """Return the heading of each panel in one line, without the note on how little its values vary."""
    titles = [axes.get_title().replace("\n", " ") for axes in page.axes if axes.get_title()]
    return [title.partition(", varies")[0] for title in titles]
