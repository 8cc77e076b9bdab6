"""Records that came from outside: what would lead out of them, or keep a caller waiting, is refused."""

import pytest

from chain_impact.kernel.soundness import sound
from chain_impact.kernel.status import LAST_STATUS, STATUS_TEXT
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.derivatives import DifferentiatedInstance
from chain_impact.simulation.instance import Instance
from chain_impact.variables.model import Model
from tests.derivative_scenes import table
from tests.plain import Plain


@pytest.fixture
def d():
    """The default chain in its first impact."""
    instance = Instance(load_scene("four_link_box"))
    instance.advance(0.4995)
    return Plain(instance.record)


def test_a_record_of_a_run_is_sound(d):
    assert sound(d) == 1


def test_the_last_status_is_the_last():
    assert max(STATUS_TEXT) == LAST_STATUS


@pytest.mark.parametrize(
    ("record", "field"),
    [
        ("model", "middle"),
        ("step", "regularized"),
        ("step", "method"),
        ("step", "made_by"),
        ("step", "dense_for"),
        ("search", "known"),
        ("contact", "law"),
        ("contact", "derived_law"),
        ("solver", "method"),
        ("statistics", "status"),
        ("touch", "active_count"),
    ],
)
@pytest.mark.parametrize("value", [-2, 1 << 40])
def test_a_number_out_of_its_range_is_not(d, record, field, value):
    d[record][field] = value
    assert sound(d) == 0


@pytest.mark.parametrize("field", ["active", "active_index", "event"])
@pytest.mark.parametrize("value", [-1, 1 << 40])
def test_nor_is_one_of_a_candidate(d, field, value):
    d["touch"][field][3] = value
    assert sound(d) == 0


@pytest.mark.parametrize(
    ("links", "path", "value"),
    [
        (2, ("candidates",), 1 << 20),
        (12, ("candidates",), 1 << 20),
        (12, ("links",), 1 << 20),  # in a kernel for any number
        (2, ("touch", "active_count"), -2),
        (12, ("step", "method"), 7),
    ],
)
def test_nor_is_one_behind_it(links, path, value):
    """Of the instances of dual numbers: by the compiled kernel, which would read beyond the record."""
    scene = table(
        [{"length": 0.1, "mass": 1.0}] * links, box={"y_min": 0.0}, initial={"angles": [1.0] * links}
    )
    instance = DifferentiatedInstance(scene, Model(scene).varied_by(["contact.stiffness"]), [0])
    assert instance.is_sound(instance.words)
    record = instance._tangents[0]
    for step in path[:-1]:
        record = record[step]
    record[path[-1]] = value
    assert not instance.is_sound(instance.words)
