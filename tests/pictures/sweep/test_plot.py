"""The picture of a sweep: every kind fits its page, and what cannot be drawn is refused."""

# Tests: pictures/sweep/layout.py, pictures/sweep/message.py

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.pictures.sweep import message, plot
from chain_impact.pictures.sweep.quantities import shown_quantities_of
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import load_scene
from chain_impact.studies.sweep.sweep import sweep
from tests.pictures.pictures import WIDTHS, check_texts
from tests.pictures.sweep.drawn_sweeps import SCENE, TEN, labels_of, sweep_page

KINDS = {
    "one number": ({"contact.restitution": "0.0:0.8:9"}, {}),
    "one choice": ({"contact.model": list(CONTACT_LAWS)}, {}),
    "number and ten choices": ({"contact.restitution": "0.1:0.8:5", "contact.model": TEN}, {}),
    "number and all choices": ({"contact.restitution": "0:0.8:5", "contact.model": list(CONTACT_LAWS)}, {}),
    "two numbers": ({"contact.restitution": "0.4,0.0,0.8,0.6", "contact.stiffness": "1e6:1e9:4:log"}, {}),
    "two choices": ({"contact.model": "flores,hertz", "solver.method": "auto,explicit"}, {}),
    "one value": ({"contact.restitution": [0.5]}, {}),
    "no run that did not fail": ({"contact.restitution": [0.0], "contact.model": ["flores", "ye"]}, {}),
}


@pytest.mark.full("more cases", but="one number")
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_drawn_and_nothing_overlaps(kind, tmp_path):
    vary, options = KINDS[kind]
    runs = sweep(SCENE, vary, **options)
    runs.plot(tmp_path / "out.png")
    assert (tmp_path / "out.png").stat().st_size > 10_000
    page = sweep_page(runs)
    renderer = FigureCanvasAgg(page).get_renderer()
    panels = [axes.get_tightbbox(renderer) for axes in page.axes]
    heads = [page._suptitle.get_window_extent(renderer)]
    heads += [legend.get_window_extent(renderer) for legend in page.legends]
    for k, box in enumerate(heads):
        assert not any(box.overlaps(other_box) for other_box in panels + heads[k + 1 :]), kind
        assert box.x0 >= 0.0
        assert box.x1 <= page.bbox.x1
    assert page.get_suptitle().startswith("FourLinkBox: ")


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("width", [84, 120, 190])  # mm
@pytest.mark.parametrize("kind", KINDS)
def test_a_page_of_any_width_has_all_panels(kind, width):
    vary, options = KINDS[kind]
    runs = sweep(SCENE, vary, **options)
    page = runs.plot(size=(width / 25.4, 16.0))
    assert page.get_figwidth() == width / 25.4
    panel_texts = [(axes.get_ylabel(), axes.get_xlabel(), axes.get_title()) for axes in page.axes]
    labels = {label.replace("\n", " ").partition(", ")[0] for texts in panel_texts for label in texts}
    assert {quantity.label for quantity in shown_quantities_of(runs).all_quantities} <= labels
    if kind in {"two choices", "number and all choices"}:
        numbers = {text.get_text() for axes in page.axes for text in axes.get_yticklabels()}
        assert {"two choices": {"auto", "explicit"}}.get(kind, {*CONTACT_LAWS}) <= numbers
    foot = [text.get_text() for legend in page.legends for text in legend.get_texts()]
    assert "failed or only impulses" in foot or kind != "number and all choices"


LONG = {
    "lines": ({"initial.angle[1]": "-1.5:1.5:5"}, {}),
    "maps": ({"link[1].center_of_mass_offset": "0:0.1:4", "initial.angular_velocity[1]": "0:1:4"}, {}),
    "samples": ({"initial.angle[1]": "-1:1", "link[1].center_of_mass_offset": "0:0.1"}, {"samples": 9}),
}


@pytest.mark.full("takes long", but=1)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("kind", LONG)
def test_the_longest_names_fit_their_panels_at_each_width(kind, width):
    values = {"outputs.loads": True, "link[1].center_of_mass_offset": 0.05, "simulation.stop_time": 0.3}
    vary, options = LONG[kind]
    page = sweep(load_scene("arm_at_stop").with_values(values), vary, **options).plot(size=(width, None))
    check_texts(page)
    for axes in page.axes:
        heading, name, axes_box = axes.title, axes.yaxis.label, axes.get_window_extent()
        assert heading.get_window_extent().width <= axes_box.width
        assert name.get_window_extent().height <= axes_box.height
    panels = [axes for axes in page.axes if axes.get_title() and kind != "samples"]
    numbered_panels = [axes for axes in panels if axes.xaxis.get_tick_params()["labelbottom"]]
    lowest = min((axes.get_position().y0 for axes in panels), default=0.0)
    assert all(axes.get_position().y0 == pytest.approx(lowest) for axes in numbered_panels)


@pytest.mark.full("takes long")
def test_a_page_that_is_too_low_is_refused():
    runs = sweep(SCENE, {"contact.restitution": "0.4,0.8"})
    with pytest.raises(ValueError, match=r"^size = \(3.3, 2\) must be at least [\d.]+ high"):
        runs.plot(size=(3.3, 2.0))


def test_names_of_rows_are_apart_by_default():
    page = sweep(SCENE, {"contact.model": TEN[:3]}).plot(panels=["peak_force", "impact.count"])
    page.draw_without_rendering()
    first, second, third = (label.get_window_extent() for label in page.axes[0].get_yticklabels())
    assert first.y0 > second.y1
    assert second.y0 > third.y1


def test_a_choice_without_a_value_has_a_word_in_its_row():
    laws = ["flores", "newton_impact", "kelvin_voigt", "zhang_sharf"]
    runs = sweep(SCENE, {"contact.model": laws})
    page = sweep_page(runs)
    words = {}
    for axes in page.axes:
        words[axes.get_title().replace("\n", " ").partition(" [")[0].partition(",")[0]] = {
            laws[round(text.get_position()[1])]: text.get_text() for text in axes.texts
        }
        _, ring = axes.lines
        assert ring.get_ydata().tolist() == [laws.index("zhang_sharf")]  # the law of the scene
        (guides,) = axes.collections  # no line lies on a word
        rows = {float(y) for (_, y), _ in guides.get_segments()}
        assert rows == {*range(len(laws))} - {text.get_position()[1] for text in axes.texts}
    assert words["peak force"] == {"newton_impact": "impulse", "kelvin_voigt": "failed"}
    assert words["largest penetration"] == {"kelvin_voigt": "failed"}
    page_text = page.get_suptitle() + "".join(text.get_text() for text in page.texts)
    assert "1 failed (exponent not allowed)" in page_text
    assert "contact.model: 4 choices, zhang_sharf in the scene (ring)" in page_text


def test_only_the_panels_that_are_named_are_drawn():
    runs = sweep(SCENE, {"contact.restitution": "0.2:0.8:3"}, outputs=["point[4].x"])
    assert labels_of(runs.plot(panels="peak*")) == ["peak force [kN]"]
    page = runs.plot(panels=["point[4].x", "energy.kinetic"])
    assert labels_of(page) == ["point[4].x at the end [m]", "energy.kinetic at the end [J]"]
    with pytest.raises(SceneError, match=r"peek_force.*the nearest is peak_force"):
        runs.plot(panels="peek_force")


def test_too_many_parameters_are_refused(tmp_path):
    names = ("x", "y", "vx", "vy", "angle[1]", "angle[2]", "angle[3]")
    runs = sweep(SCENE, {f"initial.{name}": [1.0] for name in names})
    with pytest.raises(SceneError, match="7 parameters vary, must be <= 3 for a picture"):
        runs.plot(tmp_path / "out.png")


def test_too_many_runs_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("chain_impact.pictures.sweep.plot.MOST_DRAWN", 3)
    runs = sweep(SCENE, {"contact.restitution": [0.3, 0.4, 0.5, 0.6]})
    with pytest.raises(SceneError, match="4 runs must be <= 3 for a picture: draw parts of the table"):
        runs.plot(tmp_path / "sweep.png")


def test_the_headline_tells_parameters_that_act_together():
    dependence_text = message._dependence_text
    assert dependence_text({"contact.restitution": (0.32, ""), "contact.model": (0.11, "")}).endswith(
        " together"
    )
    assert dependence_text({"contact.stiffness": (0.7, "rises"), "contact.restitution": (0.1, "")}) == (
        "rises mostly with stiffness"
    )
    assert dependence_text({"contact.stiffness": (0.4, ""), "contact.restitution": (0.35, "")}) == (
        "depends on stiffness and restitution"
    )
    assert dependence_text({"contact.stiffness": (0.1, "")}) == ""


@pytest.mark.full("takes long")
def test_a_narrow_headline_is_balanced_and_written_once(monkeypatch):
    """The picture is drawn for several heights, but its texts are composed once."""
    calls = []
    headline_parts = plot.headline_parts
    monkeypatch.setattr(
        plot, "headline_parts", lambda *args, **is_small: calls.append(1) or headline_parts(*args, **is_small)
    )
    runs = sweep(SCENE, {"contact.restitution": "0.3:0.9:5", "contact.stiffness": "1e6:1e9:5:log"})
    page = runs.plot(size=(60 / 25.4, None))
    lines = page.get_suptitle().split("\n")
    assert len(lines) == 3
    assert min(map(len, lines)) > 0.7 * max(map(len, lines))
    assert "with stiffness" in page.get_suptitle().replace("\n", " ")
    assert len(calls) == 1
    conditions = " ".join(page.texts[1].get_text().split())
    assert conditions.count("in the scene (+)") == 2
