"""The table of pinned motions, and the dialog with the impacts of all of them side by side."""

# Tests: pages/browser/explore/compared_table.js
# Tests: pages/browser/recording/partners.js, pages/browser/recording/parting.js

import operator
import re

import pytest

from chain_impact import load_scene, simulate
from tests.pages.in_pages import ADVANCE_CLOCK, PIXELS, alike, impacts_of, partners, until, until_text
from tests.tiers import needs_browser

pytestmark = needs_browser
SECONDS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "ns": 1e-9}
FIRST = operator.itemgetter(0)


def test_pins_tell_the_change_of_the_largest_force_and_align_impacts(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.5})")
    scene = load_scene("four_link_box")
    runs = [simulate(scene.with_values({"contact.restitution": e})) for e in (0.5, 0.7)]
    until_text(page, f"{len(runs[0].impacts)} impact")
    rows = page.locator("#pins tbody tr").all()
    assert "present: Restitution = 0.5" in rows[0].inner_text()
    peaks = [run.impacts["peak_force"].max() for run in runs]
    peak_texts = [f"{peak / 1e3:.1f}\u202fkN" for peak in peaks]
    peak_cells = [row.locator("td").nth(1) for row in rows]
    changes = [cell.locator("small").inner_text() for cell in peak_cells]
    assert [cell.text_content() for cell in peak_cells] == [
        force + change for force, change in zip(peak_texts, changes, strict=True)
    ]
    assert changes[1] == "", "pin A is the reference"
    percent = float(changes[0].removesuffix("\u202f%").replace("\u2212", "-"))
    assert percent == pytest.approx(100 * (peaks[0] / peaks[1] - 1), abs=0.5)
    present, pinned = (run.impacts for run in runs)
    expected = partners(present, pinned)
    assert any(k is None for k in expected)
    assert any(k not in (None, n) for n, k in enumerate(expected))
    page.get_by_role("button", name="Impact by impact…").click()
    pairs = [(present["onset"][n], n, k) for n, k in enumerate(expected)]
    pairs += [(pinned["onset"][k], None, k) for k in range(len(pinned)) if k not in expected]
    sorted_pairs = sorted(pairs, key=FIRST)
    table = page.locator("#pairs tbody tr").all()
    numbers = [row.locator("td").first.inner_text() for row in table]
    assert numbers == ["" if n is None else str(n + 1) for _, n, _ in sorted_pairs]
    cells = [row.locator("td").last.inner_text() for row in table]
    greys = [row.locator("td").last.get_attribute("class") == "doubtful" for row in table]
    for cell, is_grey, (_, n, k) in zip(cells, greys, sorted_pairs, strict=True):
        assert cell.startswith("–") if k is None else f"{pinned['onset'][k]:.4f}" in cell
        if None in (n, k):
            continue
        gap = present["onset"][n] - pinned["onset"][k]
        change = 100 * (present["peak_force"][n] / pinned["peak_force"][k] - 1)
        time, unit, percent = re.search(
            r"→ now ([+−]?[\d.]+)\u202f(\w+), ([+−]?[\d.]+)\u202f%", cell
        ).groups()
        gap_and_change = [float(text.replace("\u2212", "-")) for text in (time, percent)]
        assert gap_and_change == pytest.approx([gap / SECONDS[unit], change], rel=0.05, abs=0.06)
        is_other = alike(present, present[n]).index(n) != alike(pinned, pinned[k]).index(k)
        assert is_grey == (is_other or abs(gap) > 0.03 * min(present["onset"][n], pinned["onset"][k]))
    page.keyboard.press("Escape")
    is_clear = [
        k is None
        or abs(present["onset"][n] / pinned["onset"][k] - 1) > 0.01
        or abs(present["peak_force"][n] / pinned["peak_force"][k] - 1) > 0.01
        for _, n, k in sorted_pairs
        if n is not None
    ]
    assert rows[0].locator("td").nth(4).inner_text().startswith(f"impact {is_clear.index(True) + 1}\n")
    assert "changes from A" in page.locator("#pins thead th").first.inner_text()
    titles = page.locator("#pins thead th").evaluate_all("heads => heads.slice(4).map((head) => head.title)")
    assert len(set(titles)) == 3
    assert all(titles), "each of the last columns is explained"
    assert rows[0].locator("td").nth(4).locator("small").inner_text().count("force ") == 1
    counts = f"{len(pinned)} → {len(present)}"
    assert page.inner_text("#impacts-before") == f"from A: {counts}, {peak_texts[1]} → {peak_texts[0]}"


def places_of(run):
    return list(zip(run.impacts["point"], run.impacts["wall"], strict=True))


def test_all_motions_are_compared_with_the_one_that_the_reader_chooses(show):
    page, values = show(hash_="#contact.restitution=0.7"), (0.7, 0.8, 0.6)
    for value in values[1:]:
        page.get_by_role("button", name="Pin").click()
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_text(page, impacts_of({"contact.restitution": value}))
    scene = load_scene("four_link_box")
    runs = dict(
        zip("AB ", (simulate(scene.with_values({"contact.restitution": e})) for e in values), strict=True)
    )
    for name, letter in (("A", "A"), ("B", "B"), ("present", " ")):
        page.get_by_role("radio", name=f"Compare with {name}").check()
        assert f"changes from {name}" in page.inner_text("#pins thead")
        assert page.inner_text("#impacts-before").startswith("" if letter == " " else f"from {name}: ")
        rows = dict(zip(" AB", page.locator("#pins tbody tr").all(), strict=True))
        assert rows.pop(letter).locator("td").last.inner_text() == "reference"
        for other_letter, row in rows.items():
            counts = [len(runs[key].impacts) for key in (letter, other_letter)]
            count_change = row.locator("td").first.locator("small").inner_text().replace("−", "-")
            assert int(count_change) == counts[1] - counts[0]
            orders = zip(*(places_of(runs[key]) for key in (letter, other_letter)), strict=False)
            differing = (k for k, (place, other_place) in enumerate(orders, 1) if place != other_place)
            first = next(differing, min(counts) + 1)
            assert row.locator("td").last.inner_text().startswith(f"impact {first}, ")
            parting = float(row.locator("td").nth(3).inner_text().removesuffix("\u202fs"))
            onset = runs[letter].impacts["onset"][0]
            assert onset < parting < onset + 0.1, "the motions part after the first impact"
    assert page.evaluate(PIXELS, ["energy", "pin-1"]) > 20, "with a mark in the chart"


def test_each_impact_of_each_pin_has_one_cell(show):
    page = show(hash_="#contact.restitution=0.7")
    for value in (0.8, 0.6, 0.75):
        page.get_by_role("button", name="Pin").click()
        page.evaluate(ADVANCE_CLOCK)
        page.evaluate(f"chainImpact.show({{'contact.restitution': {value}}})")
        until_text(page, impacts_of({"contact.restitution": value}))
    page.get_by_role("button", name="Impact by impact…").click()
    rows = [row.locator("td").all_inner_texts()[1:] for row in page.locator("#pairs tbody tr").all()]
    for value, column in zip((0.75, 0.7, 0.8, 0.6), zip(*rows, strict=True), strict=True):
        run = simulate(load_scene("four_link_box").with_values({"contact.restitution": value}))
        onset_texts = [
            re.search(r"(\d\.\d{4})\u202fs", text)[1] for text in column if not text.startswith("–")
        ]
        assert sorted(onset_texts) == [f"{onset:.4f}" for onset in run.impacts["onset"]]
    lacking = [[cell.startswith("–") for cell in row] for row in rows]
    assert any(row[0] and row.count(False) > 1 for row in lacking), "partners of two pins share a row"


def test_a_change_to_many_times_the_force_is_told_as_a_factor(show):
    page = show()
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.stiffness': 1e11})")
    change = page.locator("#pins tbody tr:nth-child(1) td:nth-child(3) small")
    change.filter(has_text=re.compile(r"^×\u202f[1-9]\d(\.\d)?$")).wait_for()


def test_an_energy_of_round_off_is_0_in_the_summary(show):
    page = show("simple_pendulum")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'gravity.y': -5})")
    until(page, "document.querySelector('.pin-text').textContent.includes('−5')")
    rows = [row.locator("td").all_text_contents() for row in page.locator("#pins tbody tr").all()]
    assert [row[:3] for row in rows] == [["00", "–", "0\u202fJ0"], ["0", "–", "0\u202fJ"]]
    assert rows[0][4:] == ["none", "none"]


def test_energies_of_the_summary_are_rounded_to_the_range_of_the_runs(show):
    """At the end the energy is −25 µJ; at the start it is 3.6 J."""
    page = show("rod_drop", {"contact.restitution": 0.3})
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.8})")
    until(page, "!['', '0'].includes(document.querySelector('#pins td:nth-child(4) small').textContent)")
    cells = page.locator("#pins tbody td:nth-child(4)").all_text_contents()
    assert cells == ["0.071\u202fJ+0.071\u202fJ", "0.000\u202fJ"]


def test_forces_and_impulses_are_not_compared_and_angles_are_in_degrees(show):
    page = show()
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact', 'initial.angle[2]': -2.16})")
    until(page, "/^[0-9]+ → [0-9]+$/.test(document.getElementById('impacts-before').textContent)")
    page.get_by_role("button", name="Pin").click()
    assert "Initial angle of link 2 = −123.76\u202f°" in page.locator(".pin-text").last.inner_text()
