"""The table of the page with derivatives: changes of impacts, as numbers or colours."""

# Tests: pictures/sensitivity_table.py

from dataclasses import replace

import matplotlib as mpl
import matplotlib.style
import numpy as np
import pytest
from matplotlib.colors import rgb_to_hsv, to_hex, to_rgb
from matplotlib.figure import Figure

from chain_impact import load_scene, simulate
from chain_impact.pictures.drawing.colours import PALETTE
from chain_impact.pictures.drawing.dark_ground import lightened_colour
from chain_impact.pictures.drawing.headings import height_with_heading
from chain_impact.pictures.first_order import first_order_changes
from chain_impact.pictures.sensitivities import LARGEST_EFFECTS
from chain_impact.pictures.sensitivity_table import (
    CELL_HEIGHT,
    MOST_OPACITY,
    SIGNED_COLOURS,
    cell_text,
    draw_impact_changes,
)
from tests.helpers.scenes.stops import knee_scene, struck_rod
from tests.pictures.pictures import contrast


@pytest.fixture(scope="module")
def swing():
    return simulate("pinned_arm", sensitivities=("contact.restitution", "initial.angle[2]"))


@pytest.mark.full("takes long")
@pytest.mark.parametrize(
    ("scene", "words"),
    [(knee_scene(), "peak force or moment"), (struck_rod("zhang_sharf", 0.3), "peak moment")],
    ids=["walls and stops", "stops only"],
)
def test_a_table_with_stops_has_moments(scene, words):
    result = simulate(scene, sensitivities=["stop.restitution"])
    table = result.plot_sensitivities(outputs=["link[1].angle"]).axes[-1]
    assert table.get_title(loc="left") == f"change of {words} [%] by + 1 %"


@pytest.mark.full("takes long")
def test_many_impacts_have_colours_in_place_of_numbers():
    """Each impact has a cell; its colour has the sign of the change."""
    recording = simulate("rod_drop", sensitivities=["contact.restitution", "contact.stiffness"])
    page = recording.plot_sensitivities(size=(120.0 / 25.4, None))
    assert page.get_figheight() * 25.4 <= 160.0
    table, bar = page.axes[-2:]
    (image,) = table.images
    assert image.get_array().shape == (2, len(recording.impacts))
    assert not table.texts
    assert len(bar.get_yticks()) == 5
    assert [label.get_text() for label in bar.get_yticklabels()] == ["−10", "−1", "0", "+1", "+10"]
    assert bar.get_ylim() == pytest.approx((image.norm.vmin, image.norm.vmax))
    figure, looks = Figure(), [{"color": colour} for colour in PALETTE[:2]]
    changes = first_order_changes(recording, recording.sensitivities, ["point[1].y"])
    # the table then shows changes that no curve shows
    always_known = replace(changes, is_known=np.ones((len(recording.time), 2), bool))
    draw_impact_changes(figure.subplots(), always_known, looks)
    assert figure.axes[0].images[0].colorbar.extend == "both"  # larger changes have the colours of the ends
    assert image.colorbar.extend == "neither"
    # the middle of the logarithmic scale between 0 and an end
    half = float(image.norm.inverse(0.75))
    assert 0.05 < half / image.norm.vmax < 0.2
    negative, zero, positive = image.to_rgba(np.array([-half, 0.0, half]))
    assert negative[0] > negative[2]
    assert positive[2] > positive[0]
    assert zero[3] < 0.01
    # colours are equally strong on both sides, on white and on black
    assert [negative[3], positive[3]] == pytest.approx([0.5 * MOST_OPACITY] * 2, abs=0.01)
    for ground in (0.0, 1.0):
        assert contrast(*(c[3] * c[:3] + (1.0 - c[3]) * ground for c in (negative, positive))) < 1.05


@pytest.mark.full("takes long")
@pytest.mark.parametrize("style", ["default", "dark_background"])
def test_cells_differ_from_the_ground_and_blank_ones_are_explained(style):
    """A change of a tenth of the largest one is visible, and a grid shows cells of the change 0."""
    recording = simulate(
        "rod_drop", stop_time=1.5, sensitivities=["contact.restitution", "contact.stiffness"]
    )
    with matplotlib.style.context(style):
        page = recording.plot_sensitivities(size=(120.0 / 25.4, None))
    (image,), lines = page.axes[-2].images, page.axes[-2].collections
    ground = np.array(to_rgb(page.get_facecolor()))
    for part in (-0.1, 0.1):
        *colour, opacity = image.to_rgba(part * image.norm.vmax)
        assert contrast(opacity * np.array(colour) + (1.0 - opacity) * ground, ground) > 1.2
    assert all(contrast(line.get_colors()[0], ground) > 1.2 for line in lines)
    assert np.ma.getmaskarray(image.get_array()).any()
    assert any("grey area: no prediction" in text.get_text() for text in page.texts)


def test_numbers_of_cells_stay_legible_on_a_dark_ground(swing):
    with mpl.rc_context({"figure.facecolor": "black", "text.color": "white"}):
        table = swing.plot_sensitivities().axes[-1]
    assert [to_hex(text.get_color()) for text in table.texts] == ["#ffffff"] * 2
    for part in (0.0, 0.5, 1.0):
        *colour, opacity = SIGNED_COLOURS(part)
        for ground, text in (("black", "white"), ("white", "black")):
            mixed = opacity * np.array(colour) + (1.0 - opacity) * np.array(to_rgb(ground))
            assert contrast(mixed, text) >= 4.5
    names = [text.get_color() for text in table.get_yticklabels()]
    assert [to_hex(colour) for colour in names] == [
        to_hex(lightened_colour(colour)) for colour in PALETTE[:2]
    ]


def test_the_colours_of_the_table_are_no_colours_of_curves(swing):
    image = swing.plot_sensitivities().axes[-1].images[0]
    for change in (-100.0, -1.0, 1.0, 100.0):
        hue = rgb_to_hsv(image.to_rgba(change)[:3])[0]
        hue_distances = np.abs(
            rgb_to_hsv([to_rgb(colour) for colour in PALETTE[:LARGEST_EFFECTS]])[:, 0] - hue
        )
        assert np.minimum(hue_distances, 1.0 - hue_distances).min() > 0.05


def test_rigid_impacts_have_changes_of_impulses():
    rigid = load_scene("pinned_arm").with_values({"contact.model": "newton_impact"})
    page = simulate(rigid, sensitivities="gravity.y").plot_sensitivities()
    assert page.axes[-1].get_title(loc="left") == "change of impulse [%] by + 1 %"


@pytest.mark.full("takes long")
@pytest.mark.parametrize("width", [84.0, 120.0, 190.0])
def test_names_of_rows_do_not_narrow_the_panels(swing, width):
    """The names of rows stand left of the cells, without moving the panels to the right."""
    page = swing.plot_sensitivities(size=(width / 25.4, None))
    page.draw_without_rendering()
    *panels, table = page.axes
    assert panels[0].get_window_extent().x0 < 0.16 * page.bbox.width
    assert all(height_with_heading(axes) > axes.bbox.height for axes in panels)
    assert table.get_window_extent().x0 == pytest.approx(panels[1].get_window_extent().x0)
    names = [name.get_window_extent() for name in table.get_yticklabels()]
    cells = table.transData.transform((-0.5, 0.0))[0]
    assert all(0.0 < name.x0 < name.x1 < cells for name in names)
    assert cells - max(name.x1 for name in names) < 0.1 * page.dpi


@pytest.mark.full("takes long")
@pytest.mark.parametrize("width", [84.0, 120.0])
def test_six_parameters_have_room_in_a_column_of_a_journal(width):
    result = simulate("pinned_arm", sensitivities=["contact.*", "link[*].mass"])
    page = result.plot_sensitivities(size=(width / 25.4, None))
    assert page.get_figheight() * 25.4 <= 222.0
    (legend,) = page.legends
    title = page._suptitle.get_window_extent()
    assert title.height + legend.get_window_extent().height <= 0.15 * page.bbox.height
    assert not any("other parameter" in text.get_text() for text in legend.get_texts())
    table = page.axes[-1]
    names = [label.get_text() for label in table.get_yticklabels()]
    assert "contact.stiffness" in names
    assert "contact.exponent" not in names
    rows = len(names) + 1  # the heading of the row of the radius is a row, too
    assert table.bbox.height / page.dpi / rows == pytest.approx(CELL_HEIGHT, rel=0.05)
    assert CELL_HEIGHT * 25.4 >= 4.0
    # a parameter that is 0 has a curve only if others leave a colour for it; its cells are for the whole step
    assert names[-1] == "contact.radius + 0.01 m"
    assert "+0.59" in [text.get_text() for text in table.texts]
    assert not any("contact.radius" in text.get_text() for text in legend.get_texts())


def test_a_change_beyond_first_order_is_only_bounded():
    assert [cell_text(change) for change in (127.0, -197.0, 9.9, -10.0)] == ["> +10", "< −10", "+9.9", "−10"]
