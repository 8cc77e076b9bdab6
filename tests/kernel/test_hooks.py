"""The hooks: without effect in a plain kernel, and carriers of derivatives in a kernel with derivatives."""

# Tests: kernel/function_marks.py, kernel/combinators.py, kernel/record/operations.py

import inspect
import math
from types import SimpleNamespace

import pytest

from chain_impact.kernel import hooks
from chain_impact.kernel.record.counts import COUNTS
from chain_impact.kernel.tangent import entry
from chain_impact.kernel.tangent.duals import DIRECTIONS
from chain_impact.kernel.tangent.entry import HOOKS
from chain_impact.kernel.tangent.replay import replay, restart_tangent, start_tangent
from chain_impact.scene.scene import load_scene
from tests.helpers.kernel.plain import record_of

SIZES = {name: 2 + k for k, name in enumerate(COUNTS)}
FUNCTIONS = [member for _, member in inspect.getmembers(hooks, inspect.isfunction)]
# calls of each hook for every instance of dual numbers: the kernel's functions, in their order
NAMES_CALLED = {
    hooks.on_observe: ["set_communication_point_in_step", "fill_outputs", "is_trusted"],
    hooks.on_observe_trial: ["return_to_stored_state", "refill_outputs_but_integrals", "is_trusted"],
    hooks.on_truncate: [
        "set_communication_point_in_step",
        "store_output_state",
        "update_instance_to_communication_point",
        "move_end",
    ],
    hooks.are_tangents_sound: ["is_record_sound"],
    hooks.tangent_words: [],
}
ANSWERS = {hooks.are_tangents_sound: 1, hooks.tangent_words: 0}
# the hooks that make one call for each instance
SINGLE_CALL = {hooks.on_start: start_tangent, hooks.on_restart: restart_tangent, hooks.on_step: replay}


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_a_plain_run_has_hooks_that_do_nothing(function):
    d = record_of(load_scene("four_link_box"))
    before = d.numpy_record.tobytes()
    answer = function(d)
    assert answer == ANSWERS.get(function)
    assert d.numpy_record.tobytes() == before


@pytest.mark.parametrize("function", SINGLE_CALL, ids=lambda function: function.__name__)
def test_a_hook_that_does_one_thing_does_it_with_each(function):
    assert inspect.getclosurevars(HOOKS[function]).nonlocals == {"act": SINGLE_CALL[function]}


@pytest.mark.parametrize("function", NAMES_CALLED, ids=lambda function: function.__name__)
def test_a_hook_does_the_same_with_each_instance_of_dual_numbers(function, monkeypatch):
    called = []
    output = SimpleNamespace(words=[0.0])
    own = {"output": output, "trust": SimpleNamespace(split=0, missing=[0] * DIRECTIONS)}
    tangents = [SimpleNamespace(**SIZES, **own, words=[0.0] * 5) for _ in range(3)]
    d = SimpleNamespace(
        tangent_count=3, tangent_instances=tangents, step=SimpleNamespace(communication_point=1.5), **SIZES
    )
    d.statistics = SimpleNamespace(status=0)

    def note(name):
        def call(*arguments):
            assert arguments[0] is d or arguments[0] in tangents
            called.append((name, next(a for a in arguments if a in tangents), arguments[-1]))
            return True

        return call

    for name in {name for names in NAMES_CALLED.values() for name in names}:
        monkeypatch.setattr(entry, name, note(name))
    shared = []
    monkeypatch.setattr(entry, "copy_reason", lambda t, other: shared.append((id(t), id(other))))
    answer = HOOKS[function](d)
    first, *others = map(id, tangents)
    # the first instance gets the earliest end of all, and the other instances get it from the first
    pairs = [(first, other) for other in others] + [(other, first) for other in others]
    assert shared == ([] if function in ANSWERS else pairs)
    assert answer == {hooks.are_tangents_sound: 1, hooks.tangent_words: 15}.get(function)
    assert [(name, id(t)) for name, t, _ in called] == [
        (name, id(t)) for t in tangents for name in NAMES_CALLED[function]
    ]
    assert all(last == 1.5 for name, _, last in called if name == "set_communication_point_in_step")


def test_an_instance_of_duals_that_does_not_fit_is_not_sound(monkeypatch):
    tangents = [SimpleNamespace(**SIZES) for _ in range(2)]
    d = SimpleNamespace(tangent_count=2, tangent_instances=tangents, **SIZES)
    monkeypatch.setattr(entry, "is_record_sound", lambda t: t is not d)
    assert HOOKS[hooks.are_tangents_sound](d)
    for field in SIZES:
        setattr(tangents[1], field, 99)
        assert not HOOKS[hooks.are_tangents_sound](d)
        setattr(tangents[1], field, getattr(d, field))
    monkeypatch.setattr(entry, "is_record_sound", lambda t: t is not tangents[0])
    assert not HOOKS[hooks.are_tangents_sound](d)


@pytest.mark.parametrize(
    ("trusted", "status", "missing", "kept"),
    [
        (True, 0, (), {0, 1, 2, 3}),
        (False, 0, (), set()),
        (True, 3, (), set()),
        (True, 0, (1, 3), {0, 2}),
    ],
)
def test_slopes_that_cannot_be_trusted_are_none(trusted, status, missing, kept, monkeypatch):
    """The values of these outputs remain, and the ``kept`` directions."""
    words = [float(k) for k in range(2 * (1 + DIRECTIONS))]
    trust = SimpleNamespace(split=0, missing=[int(k in missing) for k in range(DIRECTIONS)])
    t = SimpleNamespace(output=SimpleNamespace(words=words), trust=trust)
    d = SimpleNamespace(tangent_count=1, tangent_instances=[t], statistics=SimpleNamespace(status=status))
    d.step = SimpleNamespace(communication_point=0.0)
    monkeypatch.setattr(entry, "set_communication_point_in_step", lambda t, time: None)
    monkeypatch.setattr(entry, "fill_outputs", lambda t: None)
    monkeypatch.setattr(entry, "is_trusted", lambda t: trusted)
    HOOKS[hooks.on_observe](d)
    are_trusted = [not math.isnan(number) for number in words]
    assert are_trusted == [
        k % (1 + DIRECTIONS) in {0, *(1 + direction for direction in kept)} for k in range(len(words))
    ]


def test_each_function_has_a_stand_in():
    assert set(HOOKS) == set(FUNCTIONS) == {*NAMES_CALLED, *SINGLE_CALL}
