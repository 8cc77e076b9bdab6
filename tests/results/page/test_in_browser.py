"""The page in a browser, by real events: knobs, list, console, link, command, tables, a run that fails."""

import csv
import io
import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from chain_impact import cli, explore, load_scene, simulate
from chain_impact.results.page.description import description
from chain_impact.results.view import framed, pin_mark, radius_of
from chain_impact.studies.animate import record_slowly
from tests.results.page.conftest import DESK, PHONE, packed_module
from tests.stops import knee
from tests.tiers import needs_browser

pytestmark = needs_browser
SUBTITLE = "document.getElementById('subtitle').textContent"


def wait_for(page, text):
    page.wait_for_function(f"{SUBTITLE}.includes({json.dumps(text)})")


def impacts_of(changes):
    return f"{len(simulate(load_scene('four_link_box').with_values(changes)).impacts)} impacts"


def test_a_slider_gives_another_motion_and_reset_the_first_one(show):
    page = show()
    before = page.evaluate(SUBTITLE)
    slider = page.get_by_role("slider", name="Restitution")
    slider.focus()
    slider.press("Home")
    for _ in range(4):
        slider.press("PageUp")
    value = float(page.get_by_role("textbox", name="contact.restitution").first.input_value())
    assert 0.2 < value < 0.7
    wait_for(page, impacts_of({"contact.restitution": value}))
    page.get_by_role("button", name="Reset contact.restitution").first.click()
    page.wait_for_function(f"{SUBTITLE} === {json.dumps(before)}")


def test_a_field_takes_a_number_and_refuses_another(show):
    page = show()
    field = page.get_by_role("textbox", name="contact.stiffness")
    field.fill("1e6")
    field.press("Enter")
    wait_for(page, impacts_of({"contact.stiffness": 1e6}))
    field.fill("-1")
    field.press("Enter")
    said = field.evaluate("field => field.validationMessage")
    assert said == "contact.stiffness = -1 must be a finite number > 0 [N/m^exponent]"


def test_a_slider_that_was_refused_is_right_again_after_the_next_change(browser, tmp_path):
    explore("sliding_rod", tmp_path / "rod.html")
    page = browser.new_page()
    page.goto((tmp_path / "rod.html").as_uri())
    slider = page.get_by_role("slider", name="Friction at y_min", exact=True)
    slider.press("End")
    assert "static_friction" in slider.evaluate("slider => slider.validationMessage")
    page.get_by_role("slider", name="Static friction at y_min").press("End")
    assert slider.evaluate("slider => slider.validationMessage") == ""
    slider.press("End")
    assert page.evaluate("chainImpact.parameters['wall.y_min.friction']") == "1.5"
    page.close()


def test_the_list_has_every_parameter_and_is_searched(show):
    page = show()
    page.get_by_text("All parameters").click()
    rows = page.locator(".parameter")
    rows.first.wait_for()
    assert rows.count() == len(description(load_scene("four_link_box"), [])["parameters"])
    page.get_by_role("searchbox").fill("link 2 mass")
    visible = [row.inner_text() for row in rows.all() if row.is_visible()]
    assert any("mass" in text for text in visible)
    assert len(visible) < 4
    page.get_by_role("textbox", name="link[2].mass").fill("3")
    page.keyboard.press("Enter")
    wait_for(page, impacts_of({"link[2].mass": 3.0}))
    page.get_by_role("searchbox").fill("no such thing")
    assert page.get_by_text("No parameter has such a name.").is_visible()


def test_a_law_is_chosen_by_its_id_and_described(show):
    page = show()
    page.get_by_role("combobox", name="contact.model").first.select_option(label="flores")
    wait_for(page, impacts_of({"contact.model": "flores"}))
    assert "Flores, Machado, Silva & Martins 2011" in page.locator(".sentence").inner_text()


def test_the_console_gives_the_bits_of_simulate(show):
    page = show()
    changes = {"contact.restitution": 0.5, "contact.model": "hunt_crossley", "initial.angle[1]": 0.5}
    found = page.evaluate(
        """async (changes) => {
          const run = await window.chainImpact.simulate(changes);
          const text = (array) => Array.from(new BigInt64Array(array.buffer), String);
          const some = ["point[4].x", "contact[2].y_min.force", "energy.total", "impact.count",
            "solver.steps"];
          const names = Object.keys(run.columns);
          const impacts = run.impacts.map(({ onset, wall, peak_force }) => [onset, wall, peak_force]);
          const columns = some.map((name) => [name, text(run.columns[name])]);
          return { names, time: text(run.time), columns, impacts };
        }""",
        changes,
    )
    result = simulate(load_scene("four_link_box").with_values(changes))
    assert found["names"] == list(result.columns)
    assert list(map(int, found["time"])) == result.time.view(np.int64).tolist()
    for name, column in found["columns"]:
        expected = result[name].astype(np.float64).view(np.int64).tolist()
        assert list(map(int, column)) == expected, name
    walls = result.scene.wall_names
    expected = [[row["onset"], walls[row["wall"]], row["peak_force"]] for row in result.impacts]
    assert found["impacts"] == expected


def test_a_run_that_fails_says_why_and_shows_what_came_before(show):
    page = show()
    page.evaluate("chainImpact.show({'solver.work_limit': 2000})")
    status = page.get_by_role("alert")
    status.wait_for()
    assert (
        "The simulation stopped at t = 1.62152 s: a second of simulated time takes more"
        in status.inner_text()
    )
    page.evaluate("chainImpact.show({'initial.y': -3})")
    page.wait_for_function("document.getElementById('status').textContent.includes('cannot start')")
    assert "The simulation cannot start: a contact point starts beyond a wall" in status.inner_text()
    message = page.evaluate(
        "chainImpact.simulate({'initial.y': -3}).catch((error) => [error.message, error.status])"
    )
    assert message[1] == 4
    page.evaluate("chainImpact.show({'initial.y': 1.4})")
    page.wait_for_function("document.getElementById('status').textContent.includes('stopped')")
    page.get_by_role("button", name="Reset all").click()
    status.wait_for(state="hidden")


def test_a_link_carries_the_changes(show):
    page = show(hash_="#contact.restitution=0.5&contact.model=flores")
    wait_for(page, impacts_of({"contact.restitution": 0.5, "contact.model": "flores"}))
    page.get_by_role("textbox", name="contact.restitution").fill("0.4")
    page.keyboard.press("Enter")
    page.wait_for_function("location.hash === '#contact.restitution=0.4&contact.model=flores'")
    page.evaluate("location.hash = '#contact.restitution=2'")
    page.get_by_role("alert").wait_for()
    assert (
        "The link cannot be used: contact.restitution = 2 must be" in page.get_by_role("alert").inner_text()
    )


def test_the_command_repeats_the_motion(show, tmp_path, monkeypatch, capsys):
    page = show(hash_="#contact.restitution=0.5&link[2].mass=1.5&solver.method=explicit")
    page.get_by_role("button", name="Export…").click()
    command = page.get_by_label("The command that gives the same motion").input_value()
    words = shlex.split(command)
    assert words[:3] == ["chain-impact", "simulate", "four_link_box"]
    monkeypatch.chdir(tmp_path)
    assert cli.main([*words[1:], "--csv", "a.csv"]) == 0
    with page.expect_download() as download:
        page.get_by_role("button", name="Outputs as CSV").click()
    texts = (Path(path).read_text(encoding="utf-8") for path in (download.value.path(), "a.csv"))
    here, there = (list(csv.reader(text.splitlines())) for text in texts)
    assert here[0] == there[0]
    assert [list(map(float, row)) for row in here[1:]] == [list(map(float, row)) for row in there[1:]]


def test_a_picture_shows_what_the_page_shows(show):
    page = show()
    page.get_by_role("button", name="Export…").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Picture as PNG").click()
    picture = Image.open(io.BytesIO(Path(download.value.path()).read_bytes())).convert("RGB")
    box = page.locator("#scene").bounding_box()
    assert picture.size == (2 * int(box["width"]), 2 * int(box["height"]))
    chain = np.abs(np.asarray(picture).astype(int) - [0x2B, 0x4A, 0x9F]).max(axis=-1) < 8
    assert chain.sum() > 2000


@pytest.mark.parametrize("size", [DESK, PHONE])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_stands_out_of_the_screen(show, size, scheme):
    page = show(size, color_scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.locator("#scene").is_visible()
    assert page.get_by_role("button", name="Play").is_visible()


# --- what the page works out itself: frames and view ----------------------------------------------------


@pytest.fixture(scope="module")
def motions(worker):
    """The motion that the page's worker makes of a scene."""

    def run(scene):
        given = json.loads(json.dumps(description(scene, [])))
        return worker.evaluate(
            """async ([text, scene]) => {
              const kernel = await Kernel.load(await compiled(text), scene);
              const { parts, status } = runThrough(motion(kernel, {}));
              const { time, view, anchor, pin, energies, forces, stops, radius, peakForce } = parts;
              return { status, time: [...time], view, anchor, pin, energies: Object.keys(energies), radius,
                stops, peakForce, forces: forces.map(({ point, wall }) => [point, wall]) };
            }""",
            [packed_module(), given],
        )

    return run


@pytest.mark.parametrize(
    "scene",
    [
        load_scene(name)
        for name in ("four_link_box", "pinned_arm", "kneed_leg", "ramp", "sliding_rod", "bouncing_ball")
    ]
    + [knee()],
    ids=lambda scene: scene.name,
)
def test_the_page_shows_what_an_animation_shows(motions, scene):
    found, known = motions(scene), record_slowly(scene)
    radius = radius_of(known)
    view, anchor = framed(known.points, known.walls, radius)
    size = np.ptp(view, axis=0).max()
    np.testing.assert_allclose(found["view"], view, atol=0.01 * size)
    assert found["anchor"] == anchor.tolist()
    for here, there in zip(found["pin"], pin_mark(known.points), strict=True):
        np.testing.assert_allclose(here, there, atol=0.01 * size)
    assert set(found["energies"]) == {name for name, energy in known.energies.items() if energy.any()}
    forces = {(one.point, one.wall) for one in known.touches if one.force is not None and one.force.any()}
    assert {(point, wall) for point, wall in found["forces"]} == forces
    assert found["radius"] == pytest.approx(radius, abs=1e-9)
    assert [one["joint"] for one in found["stops"]] == list(known.stops)
    # of walls only: moments of stops are drawn on a scale of their own
    peak = known.impacts["peak_force"][~known.at_stops].max(initial=0.0)
    assert found["peakForce"] == pytest.approx(peak, rel=1e-3, abs=1e-200)
    assert (found["time"][0], found["time"][-1]) == (known.time[0], known.time[-1])
    assert (np.diff(found["time"]) > 0).all()
    assert 0.5 < len(found["time"]) / len(known.time) < 2.0


# --- by hand, and other motions beside the present one --------------------------------------------------


def drag(page, grip, x, y):
    """Drag a handle by some pixels, and wait for the motion that follows."""
    box = page.locator(f'[data-grip="{grip}"]').bounding_box()
    left, top = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(left, top)
    page.mouse.down()
    page.mouse.move(left + x, top + y, steps=4)
    page.mouse.up()
    page.wait_for_timeout(300)
    return {name: float(value) for name, value in page.evaluate("Object.entries(chainImpact.parameters)")
            if re.fullmatch(r"[-+.\de]+", value)}  # fmt: skip


def changed(after, scene):
    return {name for name, value in after.items() if value != scene.values[name] and name in scene.values}


def test_a_joint_that_is_dragged_turns_its_link(show):
    page, scene = show(), load_scene("four_link_box")
    after = drag(page, "joint 4", -20, -60)
    assert changed(after, scene) == {"initial.angle[4]"}
    assert after["initial.angle[4]"] > scene.values["initial.angle[4]"]
    wait_for(page, impacts_of({"initial.angle[4]": after["initial.angle[4]"]}))


def test_the_base_that_is_dragged_takes_the_chain_along(show):
    page, scene = show(), load_scene("four_link_box")
    after = drag(page, "joint 0", 15, 25)
    assert changed(after, scene) == {"initial.x", "initial.y"}
    assert after["initial.x"] > 0.6
    assert after["initial.y"] < 1.4
    wait_for(page, impacts_of({name: after[name] for name in ("initial.x", "initial.y")}))


def test_arrows_that_are_dragged_set_velocities(show):
    page, scene = show(), load_scene("four_link_box")
    after = drag(page, "velocity 0", 30, -20)
    assert changed(after, scene) == {"initial.vx", "initial.vy"}
    assert after["initial.vx"] > 1.5
    assert after["initial.vy"] > 0.0
    after = drag(page, "velocity 4", 0, -25)
    assert changed(after, scene) == {"initial.vx", "initial.vy", "initial.angular_velocity[4]"}
    assert after["initial.angular_velocity[4]"] > scene.values["initial.angular_velocity[4]"]


def test_a_wall_that_is_dragged_moves_along_its_normal(show):
    page, scene = show(), load_scene("four_link_box")
    after = drag(page, "wall y_min", 40, -30)
    assert changed(after, scene) == {"box.y_min"}
    assert after["box.y_min"] > 0.0
    wait_for(page, impacts_of({"box.y_min": after["box.y_min"]}))


def test_there_are_handles_at_the_start_only(show):
    page = show()
    assert page.locator("[data-grip]").count() > 9
    page.keyboard.press("Shift+ArrowRight")
    page.wait_for_function("document.querySelectorAll('[data-grip]').length === 0")
    page.get_by_role("button", name="Set the start by hand").click()
    page.wait_for_function("document.querySelectorAll('[data-grip]').length > 9")


def test_the_motion_before_a_change_is_a_ghost_and_pinned_ones_stay(show):
    page = show()
    assert page.locator(".ghost").count() == 0
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.4})")
    wait_for(page, impacts_of({"contact.restitution": 0.4}))
    page.wait_for_timeout(900)
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.restitution': 0.6})")
    wait_for(page, impacts_of({"contact.restitution": 0.6}))
    assert page.locator("polyline.ghost").count() == 3
    rows = page.locator("#pins tbody tr").all_inner_texts()
    for row, text in zip(rows, ("present", "as in the scene", "contact.restitution = 0.4"), strict=True):
        assert text in row
    first = simulate("four_link_box").impacts[0]
    assert f"{first['onset']:.4f}" in rows[1]
    page.locator(".unpin").first.click()
    page.wait_for_function("document.querySelectorAll('#pins tbody tr').length === 2")
