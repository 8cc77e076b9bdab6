"""No index is negative in runs of the plain kernel: compiled code does not count from the end of an array.

The derivatives beside a run (kernel/tangent/) have the same kernel functions, but their own are not run here.
"""

# Tests: kernel/advance.py

from typing import Any

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.kernel.advance import advance, advance_to_onset
from chain_impact.kernel.chain.inputs import REINITIALIZE
from chain_impact.kernel.cost import UNLIMITED
from chain_impact.kernel.entry import trajectory
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.observe import observe
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import Scene, scene_from_dict
from tests.helpers.kernel.columns import Columns
from tests.helpers.kernel.plain import Plain, Table, record_of
from tests.helpers.scenes.derivative_scenes import AT_STOPS, pressed_tip


class Checked(np.ndarray):
    """An array that refuses a negative index."""

    def __getitem__(self, key: Any) -> Any:
        refuse_negative(key)
        return super().__getitem__(key)

    def __setitem__(self, key: Any, value: Any) -> None:
        refuse_negative(key)
        super().__setitem__(key, value)


def refuse_negative(key: Any) -> None:
    for index in key if isinstance(key, tuple) else (key,):
        numbers = (index.start, index.stop) if isinstance(index, slice) else (index,)
        assert all(number is None or number >= 0 for number in numbers), key


def checked(d: Plain) -> None:
    """Let all arrays of a record refuse negative indices."""
    for name in d.numpy_record.dtype.names:
        value = getattr(d, name)
        if isinstance(value, Plain):
            checked(value)
        elif isinstance(value, Table):
            columns = {column: value[column].view(Checked) for column in value.dtype.names}
            object.__setattr__(d, name, Columns(**columns))
        elif isinstance(value, np.ndarray):
            object.__setattr__(d, name, value.view(Checked))


def fallen(model: str, method: str) -> Scene:
    """Return two links that fall on a floor and come to rest there, one of them beside a slope."""
    return scene_from_dict(
        {
            "name": "Fallen",
            "chain": {"base": "free", "links": [{"length": 0.3, "mass": 1.0, "joint_damping": 0.1}] * 2},
            "box": {"x_min": -1.0, "y_min": 0.0},
            "walls": [{"name": "slope", "point": [0.65, 0.0], "angle": 2.0}],
            "contact": {"model": model, "stiffness": 1e5, "restitution": 0.3},
            "initial": {"position": [0.0, 0.02], "angles": [0.1, -0.1]},
            "solver": {"method": method, "tolerance": 1e-4},
            "simulation": {"stop_time": 0.3},
        },
        "fallen",
    )


SCENES = {
    "explicit": (fallen("flores", "explicit"), 0.15),
    "implicit": (fallen("flores", "implicit"), 0.15),
    "rigid": (fallen("newton_impact", "auto"), 0.3),
    "approach only": (fallen("jankowski", "auto"), 0.15),
    "stops": (AT_STOPS["stop, rigid wall"].scene, 0.44),
    "box": (load_scene("four_link_box").with_values({"solver.tolerance": 1e-4}), 0.5),
}


@pytest.mark.full("more cases", but="explicit")
@pytest.mark.parametrize("name", SCENES)
def test_no_index_is_negative(name):
    scene, time = SCENES[name]
    d = record_of(scene)
    checked(d)
    assert initialize(d, 0.0) == OK
    assert advance(d, time, UNLIMITED, UNLIMITED) == OK
    observe(d)
    assert d.impact.count > 0


@pytest.mark.full("more cases", but="zhang_sharf")
@pytest.mark.parametrize("model", ["zhang_sharf", "newton_impact"])
def test_no_index_is_negative_where_inputs_and_parameters_change(model):
    """A tip is pressed onto the floor, its law changes, a torque follows a polynomial, the tip is raised."""
    scene = pressed_tip(model).scene.with_values({"outputs.impacts": 5, "solver.tolerance": 1e-4})
    d = record_of(scene)
    checked(d)
    d.given.tip_force[1] = -30.0
    assert initialize(d, 0.0) == OK
    assert advance(d, 0.1, UNLIMITED, UNLIMITED) == OK
    assert d.contacts.active_count == 1
    d.given.restitution, d.given.pending = 0.7, REINITIALIZE
    d.given.piece.degree, d.given.piece.end, d.given.piece.scale = 2, 0.2, 1.0
    d.given.piece.motor[1] = 0.5
    assert advance_to_onset(d, 0.12) == OK
    d.given.tip_force[1], d.given.pending = 60.0, REINITIALIZE
    assert trajectory(d, np.zeros(1), np.array([0.15, 0.2]), np.array([[0, 1]]), np.zeros((2, 1)), 0) == 2
    assert d.contacts.active_count == 0
    assert d.impact.count > 0
