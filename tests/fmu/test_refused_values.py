"""A value that the solver cannot go on with: reading says so, and another one may still be set."""

import pytest

from chain_impact import CONTACT_LAWS, simulate
from tests.fmu.importer import MESSAGES, Instance, refused

# The functions before each test run in the clean process.


def looks(fmu, time, laws):
    """Energies as each law is set in turn at a time [s], with what is logged; and a step after that."""
    one, seen = Instance(fmu).start(), []
    one.step(time)
    for law in laws:
        one.set({"contact.model": law})
        MESSAGES.clear()
        seen.append([one["energy.total"], one["energy.total"], list(MESSAGES)])
    one.step(time + 0.01)
    seen.append(one["solver.status"])
    return seen


@pytest.mark.parametrize("refused", ["newton_impact"])
def test_reading_an_output_says_that_what_was_set_cannot_act(fmus, clean, refused):
    scene = simulate("rod_drop")
    first, law = scene.impacts[0], scene.scene.contact.model
    numbers = [CONTACT_LAWS[name].number for name in (law, refused, law)]
    *seen, status = clean(looks, fmus["rod_drop"], 0.5 * float(first["onset"] + first["end"]), numbers)
    (before, _, quiet), (kept, again, said), (after, _, quiet_again) = seen
    assert quiet == quiet_again == []
    assert kept == again == pytest.approx(before, rel=1e-12)
    assert after == pytest.approx(before, rel=1e-12)
    assert len(said) == 2
    for text in said:
        assert "what has been set cannot act: contact.model can change to newton_impact only" in text
    assert status == 0


def starts(fmu, changes):
    return refused(fmu, lambda one: one.start(**changes))


@pytest.mark.parametrize(
    ("model", "changes", "place"),
    [
        ("rod_drop", {"initial.y": -1.0}, "point 0 at the wall y_min"),
        ("kneed_leg", {"initial.angle[3]": 3.0}, "joint 3 at its joint_max"),
        ("sliding_rod", {"wall.y_min.friction": 0.5, "wall.y_min.static_friction": 0.4}, "the wall y_min"),
    ],
)
def test_a_start_that_is_refused_is_told_with_its_place(fmus, clean, model, changes, place):
    said = clean(starts, fmus[model], changes)
    assert "the simulation cannot start: " in said
    assert place in said
