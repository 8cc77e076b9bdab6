"""Pictures of any outputs over time."""

# Tests: pictures/curve_panels.py
# Tests: pictures/curve_looks.py, pictures/curve_peaks.py, pictures/curve_texts.py, recording/curves.py

import matplotlib.pyplot as plt
import numpy as np
import pytest

from chain_impact import UnknownNameError, load_scene, simulate
from chain_impact.pictures.curve_looks import look_indices
from chain_impact.pictures.curve_peaks import extremes, largest_vectors
from chain_impact.pictures.curves import NO_FORCE, narrow_peak
from chain_impact.pictures.drawing.colours import LOAD, PALETTE, PEAK_COLOUR
from chain_impact.pictures.over_time.energies import ENERGIES
from chain_impact.recording.curves import CLOSE_TIMES, Curves
from tests.pictures.pictures import WIDTHS, check_texts, recorded

FORCES = "contact[*].y_min.force"


@pytest.fixture(scope="module")
def result():
    return simulate("four_link_box", stop_time=0.6, output_step=0.01)


@pytest.fixture(scope="module")
def arm():
    return simulate(load_scene("pinned_arm").with_values({"outputs.loads": True}), 1.0)


def test_a_panel_for_each_unit_with_peaks_that_lie_between_rows(result):
    page = result.plot(curves=[FORCES, "point[4].*", "impact.count"], size=(10.0, 9.0))
    units = [axes.get_ylabel() for axes in page.axes]
    assert units == ["force [kN]", "position [m]", "velocity [m/s]", "acceleration [m/s²]", "impact count"]
    forces, places = page.axes[:2]
    peaks = [1e3 * np.nanmax(line.get_ydata(), initial=0.0) for line in forces.lines]
    assert sorted(peaks)[-2:] == pytest.approx(sorted(result.impacts["peak_force"]), rel=1e-3)
    assert result["contact[2].y_min.force"].max() < 0.99 * max(peaks)  # the rows miss it
    (x, _) = places.lines
    at_rows = np.isin(x.get_xdata(), result.time)
    np.testing.assert_array_equal(x.get_ydata()[at_rows], result["point[4].x"])
    assert [text.get_text() for text in places.get_legend().get_texts()] == ["point[4].x", "point[4].y"]
    # numbers at each axis of time, and a title that is true of all panels, in a narrow picture, too
    narrow = result.plot(curves=[FORCES, "point[4].*"], size=(84 / 25.4, None))
    assert [axes.xaxis.get_tick_params()["labelbottom"] for axes in narrow.axes] == [True] * 4
    assert [axes.get_xlabel() for axes in narrow.axes] == ["", "", "", "time [s]"]
    assert narrow.get_suptitle() == "FourLinkBox: 2 impacts happen in 0.6 s"
    wide_names, narrow_names = (
        {
            text.get_text()
            for axes in figure.axes
            if (legend := axes.get_legend())
            for text in legend.get_texts()
        }
        for figure in (page, narrow)
    )
    assert narrow_names == wide_names - {"impact.count"}
    counts = page.axes[-1].lines[0]
    assert counts.get_ydata()[-1] == len(result.impacts)


def test_small_lengths_are_in_millimetres_below_a_force_with_a_legend(result):
    page = result.plot(curves=[FORCES, "contact[*].y_min.penetration", "point[4].y"], size=(84 / 25.4, None))
    forces, lengths = page.axes
    assert forces.get_legend() is not None
    assert lengths.get_ylabel() == "[m]", "a point is 1 m above the floor"
    forces, depths = result.plot(curves=[FORCES, "contact[*].y_min.penetration"], size=(84 / 25.4, None)).axes
    assert forces.get_legend() is not None
    assert depths.get_ylabel() == "penetration [mm]"
    deepest = max(line.get_ydata().max() for line in depths.lines)
    assert deepest == pytest.approx(1e3 * result.impacts["max_penetration"].max(), rel=1e-2)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("width", [118, 120, 125])  # [mm]
def test_the_label_of_the_time_stays_within_the_figure(width):
    names = [FORCES, "point[1].y", "contact[*].y_min.penetration"]
    page = simulate("four_link_box").plot(curves=names, around=3, size=(width / 25.4, None))
    box = page.axes[-1].xaxis.label.get_window_extent()
    assert 0.0 <= box.x0 < box.x1 <= page.bbox.x1
    assert page.get_figheight() < 6.0


def test_energies_have_the_colours_of_the_picture_of_the_motion(result):
    (axes,) = result.plot(curves="energy.*").axes
    colours = {line.get_label().removeprefix("energy."): line.get_color() for line in axes.lines}
    assert colours == {name: ENERGIES[name] for name in result.energies if name in colours}
    assert {"kinetic", "potential", "elastic", "total"} <= colours.keys()


def test_around_an_impact_time_is_that_after_its_onset(result):
    page = result.plot(curves="contact[4].y_min.force", around=2)
    assert page.get_suptitle().endswith(" hits y_min, impact 2 of 2")
    named_page = result.plot(curves="contact[4].y_min.force", around=2, title="Fall")
    assert [named_page.get_suptitle(), "hits y_min, impact 2 of 2" in named_page.texts[1].get_text()] == [
        "Fall",
        True,
    ]
    (axes,) = page.axes
    assert axes.get_xlabel().startswith("time after the onset at ")
    keys = [text.get_text() for text in axes.get_legend().get_texts()]
    assert keys == ["contact[4].y_min", "impact", "end of impact 2"]
    end, line = axes.lines
    time, force, impact = line.get_xdata(), line.get_ydata(), result.impacts[1]
    assert len(time) >= CLOSE_TIMES
    lasting = 1e3 * (impact["end"] - impact["onset"])
    assert end.get_xdata()[0] == pytest.approx(lasting)
    assert (time[0], time[-1]) == pytest.approx((-0.5 * lasting, 2.0 * lasting))
    assert (force[(time < 0.0) | (time > lasting)] == 0.0).all()
    assert axes.get_ylabel() == "force [kN]"
    assert 1e3 * force.max() == pytest.approx(impact["peak_force"], rel=1e-4)


def test_values_that_hardly_change_are_drawn_as_changes(result):
    page = result.plot(curves=["point[4].x", "point[4].y", "link[4].angular_velocity"], around=2)
    lengths, speeds = page.axes
    assert lengths.get_ylabel() == "Δ position [mm]"
    assert speeds.get_ylabel() == "angular velocity [rad/s]"
    start = result.impacts["onset"][1]
    for line, name in zip(lengths.lines[1:], ("point[4].x", "point[4].y"), strict=True):
        assert np.interp(0.0, line.get_xdata(), line.get_ydata()) == pytest.approx(0.0, abs=1e-3)
        value = np.interp(start, result.time, result[name])
        label, *change = line.get_label().split()
        sign, amount, unit = change or ("−", "0", "m")
        assert (label, unit) == (name, "m")
        assert float(amount) * {"−": 1.0, "+": -1.0}[sign] == pytest.approx(value, abs=0.02)
    assert any("Δ: change since the onset" in text.get_text() for text in page.texts)


def test_the_label_of_a_change_has_the_whole_name_of_the_output(result):
    (axes,) = result.plot(curves=["link[3].angle", "link[4].angle"], around=2).axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert [label.split()[0] for label in labels[:2]] == ["link[3].angle", "link[4].angle"]
    assert all(label.endswith(" rad") for label in labels[:2])


def test_the_view_around_a_lasting_contact_shows_its_pulse():
    block = simulate(load_scene("rocking_block").with_values({"simulation.stop_time": 1.6}))
    page = block.plot(curves="contact[1].y_min.force", around=4)
    (axes,) = page.axes
    ends, impact = axes.get_xlim(), block.impacts[3]
    assert impact["end"] - impact["onset"] > 0.1
    time, force = axes.lines[0].get_data()
    assert ends[1] < 10.0  # ms
    assert 0.0 < time[force.argmax()] < 0.2 * ends[1]
    assert any("impact 4 stays in contact for 397 ms" in text.get_text() for text in page.texts)
    assert "end of impact 4" not in [text.get_text() for text in axes.get_legend().get_texts()]


def test_a_curve_that_lies_on_another_is_dashed(result):
    forces = ["contact[0].y_max.force", "contact[1].y_max.force"]
    (axes,) = result.plot(curves=forces).axes  # both are always zero
    lines = [line for line in axes.lines if len(line.get_xdata())]
    assert [line.get_linestyle() for line in lines] == ["-", "--"]
    assert len({line.get_color() for line in lines}) == 2


def test_a_title_of_ones_own_or_none(result):
    assert result.plot(curves="energy.total", title="Mine").get_suptitle() == "Mine"
    assert result.plot(title="Mine", panels="energy").get_suptitle() == "Mine"
    assert result.plot(title=None, panels="energy").get_suptitle() == ""


def test_curves_go_into_axes_that_are_there(result):
    figure, grid = plt.subplots(2, 1)
    assert result.plot(curves=["energy.*", FORCES], ax=grid) is grid
    assert len(grid[0].lines) == 5
    with pytest.raises(ValueError, match="there are 2 axes for 1 unit"):
        result.plot(curves="energy.total", ax=grid)
    plt.close(figure)


def test_outputs_that_cannot_be_drawn_are_refused(result):
    with pytest.raises(UnknownNameError, match="the nearest is"):
        result.plot(curves="point[4].z")
    with pytest.raises(ValueError, match="around = 3 must be from 1 to 2"):
        result.plot(curves=FORCES, around=3)
    with pytest.raises(ValueError, match="only curves are drawn around an impact"):
        result.plot(around=1)
    with pytest.raises(ValueError, match="must be <= "):
        result.plot(curves="*")


def test_zero_outputs_are_told_at_the_foot_and_large_forces_have_a_prefix(result):
    page = result.plot(curves="contact[*].*.force")
    (axes,) = page.axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    hit = [f"contact[{impact['point']}].{impact['wall_name']}" for impact in result.impacts]
    assert labels == [*sorted(set(hit)), "impact"]
    (foot_text,) = [text.get_text() for text in page.texts if "0 in the whole view" in text.get_text()]
    assert "contact[0].x_min.force" in foot_text
    assert (
        narrow_peak(result, result.curves(["contact[*].*.force"])) == 1
    )  # the command line then gives a hint
    assert axes.get_ylabel() == "force [kN]"
    assert max(line.get_ydata().max() for line in axes.lines) == pytest.approx(
        1e-3 * result.impacts["peak_force"].max(), rel=1e-2
    )
    zero_axes = result.plot(curves="contact[0].x_min.force").axes[0]
    assert len(zero_axes.lines) == 1


@pytest.mark.full("takes long")
def test_more_curves_of_a_unit_than_colours_have_a_panel_for_each_quantity(result):
    page = result.plot(curves=["point[*].x", "point[*].y"], size=(4.0, None))
    assert [axes.get_ylabel() for axes in page.axes] == ["position x [m]", "position y [m]"]
    for axes in page.axes:
        # parts of curves with dashes have no label
        colours = [line.get_color() for line in axes.lines if line.get_label() != "_"]
        assert len(colours) == len({*colours}) == 5


def test_an_owner_has_one_look_in_all_panels():
    places: dict[str, int] = {}
    assert look_indices(["link[1].angle", "link[2].angle", "link[3].angle"], places) == [0, 1, 2]
    assert look_indices(["link[3].angular_velocity", "point[1].vx"], places) == [2, 0]
    points, links = [f"point[{k}].y" for k in range(3)], ["link[1].angle", "link[2].angle"]
    places = {}
    assert [look_indices(names, places) for names in (points, links)] == [[0, 1, 2], [1, 2]]


def test_the_components_of_an_owner_have_its_colour_and_other_dashes():
    indices_of_bodies: dict[str, int] = {}
    look_indices(["joint[1].peak_force", "joint[2].peak_force"], indices_of_bodies)
    components = ["joint[2].impulse.x", "joint[2].impulse.y", "joint[1].impulse.x"]
    count = len(PALETTE)
    assert look_indices(components, indices_of_bodies) == [1, 1 + count, 0]


def test_the_contacts_of_a_point_have_the_colour_of_the_point():
    places: dict[str, int] = {}
    assert look_indices(["point[2].y", "point[4].y"], places) == [0, 1]
    contacts = ["contact[4].x_max.force", "contact[4].y_min.force", "contact[2].y_min.force"]
    assert look_indices(contacts, places) == [1, 2, 0]  # the second wall has the colour of no point
    assert look_indices(contacts[1:], places) == [2, 0]
    places = {f"point[{k}]": k for k in range(len(PALETTE))}
    assert look_indices(contacts[:2], places) == [
        4,
        4 + len(PALETTE),
    ]  # without a colour of its own, a second wall has dashes
    assert look_indices([f"contact[4].wall{k}.force" for k in range(4)], places) == [0, 1, 2, 3]


@pytest.mark.full("takes long")
def test_words_have_a_colour_only_if_the_picture_has_a_mark_of_it(result):
    narrow = (WIDTHS[0], None)
    of_curves = result.plot(curves="point[*].y", size=narrow)
    assert {text.get_color() for text in of_curves.texts}.isdisjoint({PEAK_COLOUR, LOAD})
    overview = result.plot(size=narrow)
    assert PEAK_COLOUR in {text.get_color() for text in overview.texts}
    assert LOAD not in {text.get_color() for text in overview.texts}


@pytest.mark.full("takes long")
def test_the_largest_value_of_each_force_stands_at_its_curve(arm):
    names = ["joint[*].force.*", "contact[2].x_max.force", "point[2].x"]
    for width in WIDTHS:
        page = arm.plot(curves=names, around=1, size=(width, None))
        forces, places = page.axes
        assert not places.texts
        # where the amount of a force has a curve, its components have no number
        amounts = [line for line in forces.lines if line.get_label().startswith("|")]
        assert len(forces.texts) == (3 if amounts else 5)
        for text in forces.texts:
            value, unit = text.get_text().replace("−", "-").split()
            shown_value = float(value) * {"N": 1.0, "kN": 1e3}[unit]
            peaks = [
                1e3 * line.get_ydata()[np.nanargmax(np.abs(line.get_ydata()))]
                for line in forces.lines[1:]
                if line.get_color() == text.get_color()
            ]
            assert any(shown_value == pytest.approx(peak, rel=5e-3) for peak in peaks)
        highest_curve = max(forces.lines[1:], key=lambda line: np.abs(line.get_ydata()).max())
        assert highest_curve.get_color() in {text.get_color() for text in forces.texts}
        check_texts(page)


def test_a_picture_of_an_impact_tells_its_own_and_the_largest_forces(arm, result):
    page_text = " ".join(text.get_text() for text in arm.plot(curves="joint[*].force.*", around=1).texts)
    sizes = [arm[f"joint[{number}].peak_force"].max() for number in (1, 2)]
    assert f"largest |force|: joint[1] {sizes[0]:.0f} N and joint[2] {sizes[1]:.0f} N at " in page_text
    page = result.plot(curves=FORCES, around=2)
    page_text = " ".join(text.get_text() for text in page.texts)
    assert f"{1e-3 * result.impacts['peak_force'][1]:.3g} kN in impact 2: " in page_text.replace(
        "\u00a0", " "
    )


def test_amounts_of_forces_are_drawn_beside_their_components(arm):
    names = ["joint[1].force.*", "point[2].x"]
    upper, lower = arm.plot(curves=names, around=1).axes
    lines = {line.get_label(): line for line in upper.lines}
    sizes = np.hypot(*(lines[f"joint[1].force.{axis}"].get_ydata() for axis in "xy"))
    np.testing.assert_allclose(lines["|joint[1].force|"].get_ydata(), sizes)
    has_numbers = [
        any(tick.label1.get_visible() for tick in axes.xaxis.get_major_ticks()) for axes in (upper, lower)
    ]
    assert has_numbers == [False, True]  # the numbers of the shared time stand once


def test_the_largest_force_is_the_largest_finite_one():
    time = np.arange(4.0)
    curves = [np.array([np.nan, 3.0, -5.0, np.inf]), np.full(4, np.nan), np.zeros(4), np.full(4, -np.inf)]
    (label,) = extremes(time, [(values, {"color": "k"}) for values in curves], "N", 1e-3)
    assert (label.text, label.position) == ("−5.00 N", (2.0, -5e-3))
    assert extremes(time[:0], [(values[:0], {"color": "k"}) for values in curves], "N", 1.0) == []


def test_the_lower_one_of_two_close_curves_has_its_number_below_it():
    lines = [(size * np.array([0.0, 1.0, 0.0]), {"color": "k"}) for size in (10.0, 9.5, 2.0)]
    assert [label.direction for label in extremes(np.arange(3.0), lines, "N", 1.0)] == [
        (0, 1),
        (0, -1),
        (0, 1),
    ]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(
    ("names", "title"),
    [
        ("point[*].y", "FourLinkBox: 2 impacts happen in 0.6 s"),
        ("contact[4].*.force", "FourLinkBox: contact[4].y_min.force reaches 7.48 kN"),
        (["contact[4].*.force", "point[4].y"], "FourLinkBox: 2 impacts happen in 0.6 s"),
        (FORCES, "FourLinkBox: the peak force is 19.1 kN"),
    ],
)
def test_the_headline_tells_no_force_without_a_curve(result, names, title):
    page = result.plot(curves=names)
    assert page.get_suptitle().replace("\n", " ").replace("\u00a0", " ").startswith(title)
    assert not any("bears up to" in text.get_text() for text in page.texts)


@pytest.mark.parametrize(
    ("x", "expected"),
    [
        ([np.nan, 3.0, np.inf], "largest |force|: joint[1] 5.00 N at 1 s"),
        ([np.nan, np.nan, np.inf], ""),
        ([], ""),
    ],
)
def test_the_largest_amount_of_a_force_is_finite(x, expected):
    names = ["joint[1].force.x", "joint[1].force.y"]
    values = dict(zip(names, (np.array(x), np.full(len(x), 4.0)), strict=True))
    curves = Curves(np.arange(float(len(x))), values, dict.fromkeys(names, "N"))
    assert largest_vectors(curves) == expected


def test_a_force_that_rigid_impacts_lack_has_no_panel_beside_others():
    ball = recorded("bouncing_ball")
    (axes,) = ball.plot(curves=FORCES, around=1).axes
    low, high = axes.get_ylim()
    assert -0.2 * high < low <= 0.0
    assert list(axes.get_yticks()) == [0.0]
    page = ball.plot(curves=["point[1].y", FORCES], around=1)
    assert [axes.get_ylabel() for axes in page.axes] == ["position y [mm]"]
    assert any("0 in the whole view: contact[" in text.get_text() for text in page.texts)
    assert any(NO_FORCE in " ".join(text.get_text().split()) for text in page.texts)
    page = ball.plot(curves="point[1].y", around=1)
    assert not any(NO_FORCE in " ".join(text.get_text().split()) for text in page.texts)


def test_lines_at_impacts_that_would_make_a_grey_bar_are_short():
    recording = recorded("rod_drop")
    axes = recording.plot(curves="energy.total", size=(84 / 25.4, None)).axes[0]
    (lines,) = (item for item in axes.collections if len(item.get_paths()) == len(recording.impacts))
    feet = np.array([path.vertices[:, 1].min() for path in lines.get_paths()])
    whole_onsets = recording.impacts["onset"][feet == 0.0]
    places = axes.transData.transform(np.stack([whole_onsets, np.zeros(len(whole_onsets))], axis=-1))[:, 0]
    assert 3 < len(whole_onsets) < len(feet)
    assert np.diff(places).min() * 72.0 / axes.figure.dpi > 2.0  # points


def test_a_force_that_stays_at_its_peak_has_its_number_above_its_line():
    page = recorded("stick_slip_belt").plot(
        curves=["contact[1].y_min.force", "point[*].y"], size=(84 / 25.4, None)
    )
    axes = page.axes[0]
    (label,) = axes.texts
    page.draw_without_rendering()
    assert label.get_text() == "10.0 N"
    curve = axes.lines[0]
    assert label.get_window_extent().y0 > curve.get_transform().transform(curve.get_xydata())[:, 1].max()


def test_title_and_legends_of_a_narrow_page_are_low(result):
    names = [FORCES, "point[*].y", "link[*].angular_velocity"]
    page = result.plot(curves=names, around=2, size=(84 / 25.4, None))
    page.draw_without_rendering()
    legends = [legend for axes in page.axes if (legend := axes.get_legend())]
    heads = [item.get_window_extent().height for item in (page._suptitle, *legends)]
    assert sum(heads) <= 0.22 * page.bbox.height
    assert [text.get_text() for text in legends[-1].get_texts()] == [f"link[{k}]" for k in range(1, 5)]
