"""The picture of a comparison."""

# Tests: pictures/drawing/law_looks.py, pictures/compare/looks.py, pictures/compare/grey_loops.py
# Tests: pictures/compare/headline.py

import re

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from chain_impact import CONTACT_LAWS, compare, load_scene
from chain_impact.pictures.compare.grey_loops import draw_grey_loops
from chain_impact.pictures.compare.headline import comparison_headline
from chain_impact.pictures.compare.looks import COLOURED_LAWS, brief_law_names, looks_of_laws, named_laws
from chain_impact.pictures.compare.plot import (
    SIZE,
    band_label,
    comparison_conditions,
    draw_comparison,
    laws_in_band,
    plot_comparison,
    shown_span,
)
from chain_impact.pictures.drawing.colours import GREY, INK
from chain_impact.pictures.drawing.law_looks import LAW_LOOKS
from chain_impact.pictures.over_time.energies import energy_curves
from chain_impact.scene.scene import with_values
from tests.helpers.scenes.problems import default_scene, driven


@pytest.fixture(scope="module")
def comparison():
    return compare(default_scene())


def comparison_page(comparison):
    page = Figure(figsize=SIZE, layout="constrained")
    draw_comparison(page, comparison)
    page.draw_without_rendering()
    return page


def test_the_force_of_kelvin_and_voigt_jumps_vertically_at_the_onset(comparison):
    (line,) = (
        line
        for line in comparison_page(comparison).axes[0].lines
        if line.get_label().startswith("kelvin_voigt")
    )
    depth, force = line.get_data()
    assert depth[:2].tolist() == [0.0, 0.0]
    assert force[0] == 0.0
    slope = np.diff(force[1:4]) / np.diff(depth[1:4])
    assert force[1] > 3.0  # kN
    assert slope[0] == pytest.approx(slope[1], rel=0.1)  # the curve goes on without a bend


def test_the_legend_takes_no_width_from_the_panels(comparison):
    page = comparison_page(comparison)
    (legend,) = page.legends
    boxes = [axes.get_tightbbox() for axes in page.axes]
    assert sum(box.width for box in boxes) > 0.9 * page.bbox.width
    assert legend.get_window_extent().y0 >= max(box.y1 for box in boxes) - 1.0


@pytest.mark.full("takes long")
def test_the_legend_of_a_narrow_page_is_complete(comparison):
    page = comparison.plot(size=(84 / 25.4, None))
    page.draw_without_rendering()
    (legend,) = page.legends
    box, foot = legend.get_window_extent(), " ".join(text.get_text() for text in page.texts)
    assert page.bbox.x0 <= box.x0 <= box.x1 <= page.bbox.x1
    assert len(legend.get_texts()) == COLOURED_LAWS + 1
    assert all(
        text in foot.replace("\n", " ") for text in ("; ×: first impact that differs", "grey: 11 others")
    )


@pytest.mark.parametrize(
    "model", ["four_link_box", pytest.param("hopper", marks=pytest.mark.full("more cases"))]
)
def test_title_and_legend_of_a_narrow_page_are_low(model):
    page = compare(model).plot(size=(84 / 25.4, None))
    page.draw_without_rendering()
    heads = [item.get_window_extent().height for item in (page._suptitle, *page.legends)]
    assert sum(heads) <= 0.15 * page.bbox.height


@pytest.mark.full("takes long")
def test_every_law_has_a_look_and_twins_share_one(comparison):
    labels = [re.sub(r" \(.*", "", look["label"]) for look in looks_of_laws(comparison).values()]
    assert sorted(name for label in labels for name in label.split(", ")) == sorted(CONTACT_LAWS)
    assert "ye, flores" in labels


def test_six_laws_are_named_each_in_its_own_colour_and_the_rest_is_grey(comparison):
    reasons = named_laws(comparison)
    assert reasons == {
        "zhang_sharf": "reference",
        "hertz": "no losses",
        "gharib_hurmuzlu": "differs most with losses",
        "kelvin_voigt": "force jumps at the onset",
        "hunt_crossley": "",
        "lankarani_nikravesh": "",
    }
    looks = looks_of_laws(comparison)
    coloured = {law: look["color"] for law, look in looks.items() if look["color"] not in (GREY, INK)}
    assert len(coloured) == len(set(coloured.values())) == COLOURED_LAWS
    for law, reason in reasons.items():
        (look,) = (look for look in looks.values() if law in look["label"].replace(",", "").split())
        text = look["label"].partition("(")[2]
        assert text == ", ".join(filter(None, [reason, f"e′ = {comparison[law].restitution:.2f})"]))


def test_a_law_has_the_same_colour_in_each_picture(comparison):
    assert {*LAW_LOOKS} == {*CONTACT_LAWS}
    looks = [tuple(look.values()) for look in LAW_LOOKS.values()]
    assert len({*looks}) == len(looks)
    short_comparison = compare("pinned_arm", laws=["zhang_sharf", "lankarani_nikravesh"])
    for shown_comparison in (comparison, short_comparison):
        assert (
            looks_of_laws(shown_comparison)["lankarani_nikravesh"]["color"]
            == LAW_LOOKS["lankarani_nikravesh"]["color"]
        )


def test_the_law_without_losses_has_its_own_line():
    """Without a line of its own, its constant energy would widen the band of the other laws."""
    comparison = compare("bouncing_ball", laws=["zhang_sharf", "hertz", "gharib_hurmuzlu", "newton_impact"])
    reasons = named_laws(comparison)
    assert (reasons["hertz"], reasons["gharib_hurmuzlu"]) == ("no losses", "differs most with losses")


@pytest.mark.parametrize("restitution", [0.8, 1.0])
def test_a_force_jumps_at_the_onset_only_with_losses(restitution):
    scene = load_scene("bouncing_ball").with_values({"contact.restitution": restitution})
    reasons = named_laws(compare(scene, laws=["zhang_sharf", "kelvin_voigt"]))
    assert ("jumps" in reasons.get("kelvin_voigt", "")) == (restitution < 1.0)


def test_lines_have_dashes_only_where_they_coincide_and_none_in_the_legend():
    """The energies of the laws coincide up to the first impact only, and their loops near both ends."""
    page = comparison_page(
        compare(default_scene(), laws=["zhang_sharf", "hunt_crossley", "flores", "gharib_hurmuzlu"])
    )
    for axes in page.axes:
        dashed = [line for line in axes.lines if line.get_linestyle() == "--"]
        solid = {line.get_label().partition(" ")[0]: line for line in axes.lines if line not in dashed}
        assert {*solid} == {"zhang_sharf", "hunt_crossley", "flores", "gharib_hurmuzlu"}
        assert dashed
        assert {line.get_color() for line in dashed} < {line.get_color() for line in solid.values()}
        curve = solid["hunt_crossley"].get_xydata()
        for line in dashed:
            points = line.get_xydata()[~np.isnan(line.get_xydata()[:, 0])]
            gaps = [np.hypot(*((curve - point) / np.nanmax(curve, axis=0)).T).min() for point in points]
            assert np.median(gaps) < 0.03
    (legend,) = page.legends
    assert {line.get_linestyle() for line in legend.get_lines() if line.get_label()[0] != "_"} <= {
        "-",
        "None",
    }
    assert len(legend.get_texts()) == 5


def test_the_scenes_own_law_is_named():
    comparison = compare(
        with_values(default_scene(model="jankowski"), {("simulation", "stop_time"): 0.6}),
    )
    assert named_laws(comparison)["jankowski"] == "of the scene"
    assert len(named_laws(comparison)) == COLOURED_LAWS


def test_no_law_with_losses_differs_more_than_the_law_that_differs_most(comparison):
    """Differences are relative to the reference, also if it has another restitution than requested."""
    for shown_comparison in (
        comparison,
        compare(driven(), laws=["zhang_sharf", "flores", "lee_wang", "newton_impact"]),
    ):
        expected = shown_comparison[shown_comparison.reference].restitution
        deviations = {
            run.law: abs(run.restitution - expected) for run in shown_comparison.runs if run.law != "hertz"
        }
        extremes = [law for law, reason in named_laws(shown_comparison).items() if "differs most" in reason]
        rest = [deviations[law] for law in deviations if law not in extremes]
        assert min(deviations[law] for law in extremes) >= max(rest)


def test_an_impact_that_is_not_free_is_told_in_the_picture():
    comparison = compare(driven(), laws=["zhang_sharf", "flores"])
    assert f"not free: e′ = {comparison.reached[0].lossless:.2f} without losses" in comparison_conditions(
        comparison, looks_of_laws(comparison)
    )


def test_a_restitution_above_1_without_losses_is_explained():
    comparison = compare("pinned_arm", laws=["zhang_sharf", "hertz"])
    assert f"{comparison['hertz'].restitution:.2f}" == "1.01"
    assert comparison.is_free
    text = comparison_conditions(comparison, looks_of_laws(comparison))
    assert "with other forces during the impact: e′ = 1.01 without losses" in text


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("width", [84, 120, 190])
def test_a_law_of_impulses_has_a_line_and_a_name_at_each_width(comparison, width):
    page = comparison.plot(size=(width / 25.4, None))
    (line,) = (line for line in page.axes[0].lines if line.get_label() == "newton_impact (impulse)")
    assert list(line.get_xdata()) == [0.0, 0.0]
    (legend,) = page.legends
    assert line.get_label() in {text.get_text() for text in legend.get_texts()}


def test_laws_of_impulses_alone_are_drawn():
    page = compare("bouncing_ball", laws=["newton_impact"]).plot()
    (line,) = page.axes[0].lines
    assert list(line.get_xdata()) == [0.0, 0.0]


def test_grey_loops_have_an_area_also_where_the_penetration_grows_again():
    loops = Figure().subplots()
    law = np.array([[0.0, 1.0, 0.5, 0.8, 0.0], [0.0, 2.0, 1.0, 1.5, 0.0]])
    draw_grey_loops(loops, [law])
    (area,) = loops.collections
    assert isinstance(area, PolyCollection)
    edges = area.get_paths()[0].vertices
    for depth, low, high in ((0.25, 0.46875, 0.5), (0.9, 1.8, 1.8), (0.65, 1.21875, 1.3)):
        heights = [y for x, y in edges if abs(x - depth) < 0.002]
        assert min(heights) == pytest.approx(low, abs=0.01)
        assert max(heights) == pytest.approx(high, abs=0.01)


def test_a_band_without_restitutions_names_the_extreme_forces():
    comparison = compare("hopper")
    looks = looks_of_laws(comparison)
    band = laws_in_band(comparison, looks)
    forces = {law: comparison[law].peak_force for law in band}
    ends = [min(forces, key=forces.get), max(forces, key=forces.get)]
    label = band_label(comparison, band)
    assert [label.index(law) for law in ends] == sorted(label.index(law) for law in ends)
    assert label.count("N)") == 2


def test_a_free_impact_is_not_called_otherwise(comparison):
    assert "free" not in comparison_conditions(comparison, looks_of_laws(comparison))


def test_the_range_of_peak_forces_is_told(comparison):
    runs = [run for run in comparison.runs if run.law not in ("hertz", "newton_impact")]
    forces = [1e-3 * run.peak_force for run in runs if run.peak_force > 0.0]
    hertz = 1e-3 * comparison["hertz"].peak_force
    assert f"hertz, without e: peak force {hertz:.1f} kN" in comparison_conditions(
        comparison, looks_of_laws(comparison)
    )
    expected = f"peak force {min(forces):.1f} to {max(forces):.1f} kN"
    assert expected in comparison_headline(comparison)
    assert expected in comparison_conditions(comparison, looks_of_laws(comparison), is_small=True)


@pytest.mark.parametrize(
    ("model", "pattern"),
    [
        ("pinned_arm", r"PinnedArm: restitution is [\d.]+ to [\d.]+"),
        ("sliding_rod", r"SlidingRod: peak force is [\d.]+ to [\d.]+ k?N"),
    ],
)
def test_the_headline_of_a_narrow_page_is_a_sentence(model, pattern):
    comparison = compare(model, laws=["zhang_sharf", "gonthier"])
    assert re.fullmatch(pattern, comparison_headline(comparison, is_small=True).replace("\u00a0", " "))


def test_a_narrow_headline_is_true_of_all_drawn_laws():
    with_hertz = compare("pinned_arm", laws=["zhang_sharf", "gonthier", "hertz"])
    assert comparison_headline(with_hertz, is_small=True).endswith(" with losses"), "hertz reaches more"
    with_one = compare("pinned_arm", laws=["flores", "hertz"])
    restitution = with_one["flores"].restitution
    assert (
        comparison_headline(with_one, is_small=True)
        == f"PinnedArm: flores reaches restitution {restitution:.2f}"
    )


@pytest.mark.parametrize("is_small", [False, True])
def test_the_headline_of_impulses_alone_says_that_there_is_no_peak_force(monkeypatch, is_small):
    impulses = compare("bouncing_table", laws=["newton_impact"])
    monkeypatch.setattr(type(impulses), "no_restitution", "the impact is not free")
    assert comparison_headline(impulses, is_small=is_small) == "BouncingTable: no law has a peak force"


def test_the_energy_has_the_zero_of_the_picture_of_the_motion():
    comparison = compare("pinned_arm", laws=["zhang_sharf", "hertz"])
    _, energy = comparison_page(comparison).axes
    (motion,) = (
        look["label"] for _, look in energy_curves(comparison["hertz"].result) if "total" in look["label"]
    )
    assert energy.get_ylabel() == f"{motion} [J]"
    shift = float(motion.split()[2])
    (line,) = (line for line in energy.lines if line.get_label().startswith("hertz"))
    time, energies = comparison["hertz"].result.detailed_energies
    assert len(time) > len(comparison["hertz"].result.time), "a line has points between rows"
    np.testing.assert_allclose(line.get_ydata(), energies["total"] + shift)


def test_the_energy_begins_shortly_before_the_first_impact(comparison):
    (_, energy), onset = comparison_page(comparison).axes, comparison.first_impact["onset"]
    start, end = energy.get_xlim()
    assert 0.0 < onset - start < 0.2 * (end - start)


def test_the_panels_show_loops_and_energy(comparison):
    page = comparison_page(comparison)
    loops, energy = page.axes
    looks = looks_of_laws(comparison)
    law_count = sum(look["color"] not in (GREY, INK) for look in looks.values())
    laws = [[line for line in axes.lines if line.get_label()[0] != "_"] for axes in page.axes]
    coloured = [[line for line in lines if line.get_color() not in (GREY, INK)] for lines in laws]
    assert [*map(len, coloured)] == [law_count, law_count]
    line = next(line for line in loops.lines if line.get_label().startswith("zhang_sharf"))
    np.testing.assert_allclose(line.get_xydata().T, comparison["zhang_sharf"].loop * [[1e3], [1e-3]])
    names = [axes.get_xlabel() for axes in page.axes] + [axes.get_ylabel() for axes in page.axes]
    assert sum("[" in name for name in names) == 4
    (legend,) = page.legends
    labels = [text.get_text() for text in legend.get_texts()]
    # three more entries: a law of impulses, the grey laws, and the mark where impacts differ
    assert len(labels) == COLOURED_LAWS + 3
    ends = {
        run.law: run.restitution for run in comparison.runs if looks.get(run.law, {}).get("color") == GREY
    }
    for law in (min(ends, key=ends.get), max(ends, key=ends.get)):
        assert law in labels[-2]
    thin = [line.get_xydata() for line in loops.lines if line.get_color() == GREY]
    assert len(thin) == len([law for law in ends if comparison[law].loop.size])
    band = energy.collections[0]
    low, high = band.get_datalim(energy.transData).intervaly
    last = [comparison[law].result.energy["total"][-1] for law in ends if comparison[law].result]
    assert low <= min(last) <= max(last) <= high


def test_the_headline_has_the_spread_of_the_laws(comparison):
    page = comparison_page(comparison)
    message, conditions = (text.get_text().replace("\n", " ") for text in page.texts)
    restitutions = [run.restitution for run in comparison.runs if run.law not in ("hertz", "newton_impact")]
    assert re.search(
        r"(\d+) laws with losses reach restitution ([\d.]+) to ([\d.]+) and peak", message
    ).groups() == (
        str(len(CONTACT_LAWS) - 2),
        f"{min(restitutions):.2f}",
        f"{max(restitutions):.2f}",
    )
    assert "grey" not in conditions, "the legend names the grey laws"
    legend = [text.get_text() for text in page.legends[0].get_texts()]
    law_names = [law for text in legend[:-2] for law in text.partition(" (")[0].split(", ")]
    assert legend[-2].startswith(f"{len(CONTACT_LAWS) - len(law_names)} other laws")


def test_a_mark_tells_from_where_on_impacts_differ_from_the_reference(comparison):
    _, energy = comparison_page(comparison).axes
    assert any("differs from zhang_sharf" in collection.get_label() for collection in energy.collections)
    marks = {
        float(collection.get_offsets()[0, 0]): collection.get_edgecolor()[0]
        for collection in energy.collections
        if len(collection.get_offsets()) == 1
    }
    looks = looks_of_laws(comparison)
    for law in {*named_laws(comparison)} & {*looks}:
        if (time := comparison[law].divergence_time) > 0.0:
            assert marks[time] == pytest.approx(to_rgba(looks[law]["color"]))


@pytest.mark.parametrize(
    ("model", "reason"),
    [("sliding_rod", "push on during this contact"), ("whip", "drive this contact apart")],
)
def test_no_restitution_is_told_where_other_forces_decide(model, reason):
    comparison = compare(
        model, laws=["zhang_sharf", "hertz", "gonthier", "kelvin_voigt", "hunt_crossley", "tsuji"]
    )
    assert not comparison.has_restitution
    texts = [text.get_text() for text in comparison_page(comparison).texts]
    assert "peak force" in texts[0]
    assert "restitution" not in texts[0]
    assert reason in texts[1]
    assert not any("e′" in look["label"] for look in looks_of_laws(comparison).values())


def test_an_impact_without_speed_has_no_restitution():
    comparison = compare("rocking_block", laws=["hertz", "flores"])
    assert not comparison.has_restitution
    assert not any(run.restitution > 0.0 for run in comparison.runs)


def test_the_headline_counts_no_grey_laws_where_there_are_none():
    page = comparison_page(compare("rod_drop", laws=["flores", "hertz"]))
    assert "grey" not in page.texts[1].get_text()


@pytest.mark.full("takes long")
def test_laws_that_did_not_run_leave_the_others_in_the_picture(tmp_path):
    comparison = compare(
        with_values(default_scene(model="hertz", restitution=0.0), {("simulation", "stop_time"): 0.6})
    )
    plot_comparison(comparison, tmp_path / "laws.svg")
    assert "<svg" in (tmp_path / "laws.svg").read_text(encoding="utf-8")


def test_a_law_whose_lines_are_covered_is_named_with_the_law_above_it():
    comparison = compare("elastic_ball", laws=["zhang_sharf", "hertz", "tsuji", "jankowski", "newton_impact"])
    looks = looks_of_laws(comparison)
    assert not [look for look in looks.values() if look["color"] == GREY]
    assert "grey" not in comparison_conditions(comparison, looks)
    (label,) = (look["label"] for look in looks.values() if "zhang_sharf" in look["label"])
    assert {"tsuji", "jankowski"} <= {*label.partition(" (")[0].split(", ")}


@pytest.mark.parametrize(
    ("label", "expected"),
    [("ye (e′ = 0.5)", "ye"), ("flores, ye (of the scene)", "flores (ye)"), ("a, b, c, d", "a (+ 3)")],
)
def test_a_line_that_laws_share_has_their_names_at_its_end(label, expected):
    assert brief_law_names(label) == expected


def test_the_energy_ends_when_all_laws_with_losses_have_settled(comparison):
    for shown_comparison in (comparison, compare("rod_drop", laws=["zhang_sharf", "hertz", "flores"])):
        start, end = shown_span(shown_comparison)
        assert (
            start
            < shown_comparison.first_impact["onset"]
            < end
            <= shown_comparison[shown_comparison.reference].result.time[-1]
        )
        for run in shown_comparison.runs:
            if run.law != "hertz" and run.result is not None:
                total = run.result.energy["total"]
                late = total[run.result.time > end]
                assert np.abs(late - total[-1]).max(initial=0.0) < 0.03 * total[0]
