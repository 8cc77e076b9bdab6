"""No index of the kernel is negative: compiled, it would not count from the end of an array."""

from typing import Any

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.kernel.advance import advance
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.observe import observe
from chain_impact.kernel.status import OK
from chain_impact.kernel.work_limit import UNLIMITED
from chain_impact.scene.scene import Scene, scene_from_dict
from chain_impact.variables.model import Model
from tests.derivative_scenes import AT_STOPS
from tests.plain import Plain


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
    for name, value in vars(d).items():
        if isinstance(value, Plain):
            checked(value)
        elif isinstance(value, np.recarray):
            columns = {column: value[column].view(Checked) for column in value.dtype.names}
            object.__setattr__(d, name, Columns(columns))
        elif isinstance(value, np.ndarray):
            object.__setattr__(d, name, value.view(Checked))


class Columns:
    """The columns of a table."""

    def __init__(self, columns: dict[str, Any]) -> None:
        self.__dict__.update(columns)


def fallen(model: str, method: str) -> Scene:
    """Two links that fall on a floor and come to rest there, one of them beside a slope."""
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


@pytest.mark.parametrize("name", SCENES)
def test_no_index_is_negative(name):
    scene, time = SCENES[name]
    d = Plain(Model(scene).new_instance()[0])
    checked(d)
    assert initialize(d, 0.0) == OK
    assert advance(d, time, UNLIMITED, UNLIMITED) == OK
    observe(d)
    assert d.impact.count > 0
