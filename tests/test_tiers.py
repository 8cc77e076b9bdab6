"""What is in the quick tier, and what --full says where something is missing."""

from types import SimpleNamespace

import pytest

from tests import tiers

MARK = pytest.mark.full
QUICK, SLOW, CASES = "a.py::quick", "a.py::slow", [f"a.py::cases[{k}]" for k in range(3)]


def item(nodeid, mark=None):
    return SimpleNamespace(nodeid=nodeid, get_closest_marker=lambda _: mark and mark.mark)


@pytest.mark.parametrize(
    ("full", "arguments", "left"),
    [
        (False, ["tests"], [QUICK, CASES[0]]),
        (False, [SLOW, CASES[2]], [QUICK, SLOW, CASES[0], CASES[2]]),
        (True, ["tests"], [QUICK, SLOW, *CASES]),
    ],
)
def test_a_marked_test_runs_if_all_do_or_if_it_is_named(full, arguments, left):
    items = [
        item(QUICK),
        item(SLOW, MARK("takes long")),
        *(item(case, MARK("cases", but=1)) for case in CASES),
    ]
    gone = []

    def deselected(items):
        gone.extend(one.nodeid for one in items)

    hook = SimpleNamespace(pytest_deselected=deselected)
    tiers.leave_out(SimpleNamespace(option=SimpleNamespace(full=full), args=arguments, hook=hook), items)
    assert [one.nodeid for one in items] == left
    assert {*left, *gone} == {QUICK, SLOW, *CASES}


@pytest.mark.parametrize("mark", [MARK, MARK(3), MARK("why", but=1, or_not=2)])
def test_a_mark_without_a_reason_is_refused(mark):
    with pytest.raises(pytest.UsageError, match=r"^a\.py::test: the marker must be"):
        tiers.first_cases(mark.mark, item("a.py::test"))


@pytest.mark.parametrize(
    ("module", "browser", "missing"),
    [
        ("numba", "chromium", "the extras compiler, "),
        ("playwright", "chromium", "the extras browser, "),
        (None, None, "Chromium and Firefox: "),
    ],
)
def test_full_names_what_is_missing(monkeypatch, module, browser, missing):
    monkeypatch.setattr(tiers, "find_spec", lambda name: name != module)
    monkeypatch.setattr(tiers, "CHROMIUM", browser)
    with pytest.raises(pytest.UsageError) as caught:
        tiers.refuse_what_is_missing()
    assert missing in str(caught.value)
    assert "\n" not in str(caught.value)
