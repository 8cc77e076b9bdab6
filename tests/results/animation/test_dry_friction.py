"""Dry friction in animations: arrows that lean, and marks of what sticks, in a film and in a browser."""

import math
import re

import numpy as np
import pytest

from chain_impact.results.animation import animate
from chain_impact.results.animation.film import draw_frames
from chain_impact.results.animation.film_page import FORCE
from chain_impact.results.animation.frames import motion_of
from chain_impact.results.animation.page import data
from chain_impact.studies.slow_motion import record_slowly
from tests.friction import SLOPE, pendulum, sled
from tests.results.animation.test_film import SIZE, coloured
from tests.tiers import needs_browser

SLIDES, STICKS = 0.5, 1.5  # s, of the sled
WEIGHT = 1.2 * 9.81  # N


@pytest.fixture(scope="module")
def motion():
    return motion_of(record_slowly(sled()))


def frame_at(motion, time):
    return int(np.searchsorted(motion.time, time))


def test_a_motion_has_the_friction_and_what_sticks(motion):
    assert set(motion.friction) == set(motion.sticking) == {(0, "slope"), (1, "slope")}
    at = frame_at(motion, STICKS)
    force, friction = motion.forces[0, "slope"][at], motion.friction[0, "slope"][at]
    assert math.hypot(force, friction) == pytest.approx(0.5 * WEIGHT, rel=1e-3)
    sticking = motion.sticking[0, "slope"]
    assert sticking[at]
    assert not sticking[frame_at(motion, SLIDES)]
    assert "friction" in motion.energies


@pytest.mark.full("takes long")
def test_of_a_joint_only_that_it_sticks():
    motion = motion_of(record_slowly(pendulum()))
    assert motion.friction == {}
    assert set(motion.sticking) == {(1, ""), (2, "")}


def test_the_page_holds_friction_in_spans_of_frames(motion):
    found = data(motion, 1.0)
    assert found["stuckJoints"] == []
    (first, last), *more = found["forces"][0]["spans"]
    assert more == []
    assert (first, last) == (int(np.argmax(motion.sticking[0, "slope"])), len(motion.time) - 1)
    assert found["forces"][0]["friction"]["low"] < -2.0
    joints = data(motion_of(record_slowly(pendulum())), 1.0)["stuckJoints"]
    assert [(one["joint"], len(one["spans"])) for one in joints] == [(1, 1), (2, 2)]


def test_a_film_shows_more_in_the_colour_of_forces_where_something_sticks(motion):
    frames = np.array([frame_at(motion, time) for time in (SLIDES, STICKS)])
    slides, sticks = draw_frames(motion, frames, SIZE, lambda _: None)
    assert coloured(sticks, FORCE) > coloured(slides, FORCE) > 20
    joints = motion_of(record_slowly(pendulum()))
    frames = np.array([frame_at(joints, time) for time in (0.2, 0.6)])
    free, stuck = draw_frames(joints, frames, SIZE, lambda _: None)
    assert coloured(stuck, FORCE) > coloured(free, FORCE) == 0


@pytest.fixture
def show(browser, tmp_path):
    """Open the page of a scene at a time, which must not complain."""
    said, opened = [], []

    def show(scene, time):
        path = tmp_path / "page.html"
        animate(record_slowly(scene), path)
        page = browser.new_page(viewport={"width": 1280, "height": 760}, reduced_motion="reduce")
        opened.append(page)
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto(path.as_uri())
        page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
        set_time = "(e, t) => { e.value = t; e.dispatchEvent(new Event('input', { bubbles: true })); }"
        page.locator("#scrub").evaluate(set_time, time)
        page.wait_for_function(
            f"Math.abs(parseFloat(document.getElementById('time').textContent) - {time}) < 0.02"
        )
        return page

    yield show
    for page in opened:
        page.close()
    assert said == []


def lean(page):
    """The angle [rad] from upright of the arrow of the first force, positive to the left."""
    x1, y1, x2, y2 = (
        float(page.locator("line.arrow").first.get_attribute(name)) for name in ("x1", "y1", "x2", "y2")
    )
    return math.atan2(x1 - x2, y1 - y2)


@needs_browser
def test_arrows_lean_against_the_motion_and_a_bar_shows_what_sticks(show):
    page = show(sled(), SLIDES)
    assert lean(page) == pytest.approx(math.atan(0.5) - SLOPE, abs=0.01)
    assert page.locator(".stick-bar").count() == 0
    page = show(sled(), STICKS)
    assert lean(page) == pytest.approx(0.0, abs=0.01), "it holds the weight"
    assert page.locator(".stick-bar").count() == 2
    told = [float(re.match(r"[\d.]+", text)[0]) for text in page.locator(".force-text").all_text_contents()]
    assert told == pytest.approx([0.5 * WEIGHT] * 2, abs=0.01)
    assert page.text_content("#close-what").endswith("brown: friction")
    assert "friction" in page.text_content("#energies")


@needs_browser
def test_a_full_dot_shows_a_joint_that_sticks(show):
    assert show(pendulum(), 0.2).locator(".stuck-joint").count() == 0
    assert show(pendulum(), 0.6).locator(".stuck-joint").count() == 1
    assert show(pendulum(), 3.0).locator(".stuck-joint").count() == 2
