"""Features that Python users expect: help, tab completion, copies, pickles, short reprs."""

import copy
import inspect
import multiprocessing
import pickle
import pydoc

import pytest

import chain_impact
from chain_impact import Chain, SceneError, load_scene, record_slowly, simulate
from tests.helpers.tools.refusal import refusal
from tests.helpers.tools.reprs import is_short


def test_help_shows_no_address_and_tab_completion_the_public_names_only():
    pages = {
        name: pydoc.render_doc(getattr(chain_impact, name), renderer=pydoc.plaintext)
        for name in chain_impact.__all__
    }
    assert [name for name, text in pages.items() if " at 0x" in text or "<lambda>" in text] == []
    assert dir(chain_impact) == sorted(chain_impact.__all__)
    assert inspect.ismodule(chain_impact.scene.scene), "the modules can be imported all the same"


def test_progress_can_be_left_out_or_given():
    fractions = []
    simulate("bouncing_ball", 0.5, progress=fractions.append)
    assert fractions[-1] == 1.0
    assert simulate("bouncing_ball", 0.5, progress=None).time[-1] == 0.5


LONGEST = 20  # lines


def test_the_reprs_of_what_is_computed_are_short():
    result = simulate("four_link_box", sensitivities=["gravity.y"])
    chain = Chain("pinned_arm")
    chain.step(0.25)
    recording = record_slowly("bouncing_ball")
    for thing in (result.sensitivities, chain):
        assert is_short(repr(thing))
    for thing in (result, recording):  # with the first ten impacts
        assert len(repr(thing).splitlines()) <= LONGEST
    assert repr(chain) == "Chain(PinnedArm) of 2 links at t = 0.25 s"
    assert repr(recording).startswith("BouncingBall  0 … 10 s, ")
    assert repr(result.sensitivities).endswith("with respect to gravity.y")


# --- copies and pickles of a chain -------------------------------------------------------------------------


@pytest.fixture
def chain():
    chain = Chain(load_scene("pinned_arm").with_values({"inputs.tip_force": True}))
    chain.set({"tip.force.x": 3.0})
    chain.step(0.4)
    return chain


def finished(chain):
    """Return the saved state of a chain after the next half second."""
    chain.step(0.5)
    return chain.save()


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda chain: pickle.loads(pickle.dumps(chain))]
)
def test_a_copy_of_a_chain_goes_on_bit_by_bit_and_for_itself(chain, copied):
    other = copied(chain)
    assert (other.time, other.scene, other.get("tip.force.x")) == (0.4, chain.scene, 3.0)
    expected = finished(chain)
    assert other.time == 0.4, "it stands where it stood"
    assert finished(other) == expected
    assert len(other.impacts) == len(chain.impacts) > 0
    other.reset()
    assert (other.time, other.get("tip.force.x")) == (0.0, 0.0)
    changed_chain = Chain("rod_drop")  # parameters can be set before the start
    changed_chain.set("initial.y", 1.25)
    other = copied(changed_chain)
    other.set("initial.y", 1.5)
    assert (changed_chain.get("point[0].y"), other.get("point[0].y")) == (1.25, 1.5)


def test_a_chain_goes_on_in_another_process(chain):
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        [result] = pool.map(finished, [chain])
    assert result == finished(chain)


def test_bytes_that_are_no_saved_state_of_the_scene_are_refused(chain):
    for wrong in ("x", None, 5, [1, 2]):
        message = refusal(chain.restore, wrong)
        assert message == f"PinnedArm: restore({wrong!r}) must be given the bytes that save() returned"
    with pytest.raises(SceneError, match="the bytes are no state of this scene"):
        chain.restore(b"x")
    state = chain.save()
    Chain(chain.scene.with_values({})).restore(state)
    other = Chain(chain.scene.with_values({"gravity.y": -9.80665}))  # a scene whose repr is equal
    with pytest.raises(SceneError, match="no state of this scene"):
        other.restore(state)
