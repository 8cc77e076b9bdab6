"""The ranges of parameters in the kernel's record, against the ranges of their keys in the scene."""

# Tests: kernel/record/ranges.py

import math
import re
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from chain_impact.kernel import record
from chain_impact.kernel.record.fields import LARGEST_DOUBLE, SMALLEST_DOUBLE
from chain_impact.kernel.record.ranges import (
    BOUNDED_PATHS,
    RANGE_LEAST,
    RANGE_MOST,
    RANGED_PATHS,
    bounded_field,
    least_bound,
    most_bound,
)
from chain_impact.kernel.status import PARAMETER_OUT_OF_RANGE
from chain_impact.scene.texts.unit_text import unit_text
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.instance import Instance
from chain_impact.variables.parameters import PARAMETERS
from tests.helpers.kernel.plain import Plain
from tests.helpers.scenes.derivative_scenes import table

RANGES = dict(zip(RANGED_PATHS, zip(RANGE_LEAST, RANGE_MOST, strict=True), strict=True))
KINDS = {
    kind.name: kind
    for owner, kinds in PARAMETERS
    for kind in kinds
    if owner not in ("material", "step") and not kind.choices
}
"""The real parameters, without those of materials, which laws check, and without steps of signals."""
OTHER_CHECKS = {
    ("chain", "gravity"),  # the kernel checks that the state and its energy at the start are finite
    *(("initial", name) for name in ("position", "velocity", "angle", "angular_velocity")),
    *(("drive", stop) for stop in ("min", "max")),  # one stop is below the other
    *(("given", name) for name in ("stiffness", "restitution", "friction", "static_friction")),  # by the law
    *(("given", "stop_stiffness"), ("stops", "restitution")),
    # the knots of a signal are finite and in order
    *(("signal", name) for name in ("value", "mean", "initial", "final", "start", "duration")),
}
WIDER = {
    ("chain", "height"): (0.0, LARGEST_DOUBLE),  # 0: the link is not a box
    ("signal", "frequency"): (-LARGEST_DOUBLE, LARGEST_DOUBLE),
}
"""Ranges in the kernel that are wider than those of the keys."""


def range_of_key(kind):
    """Return the range in the kernel that follows from the metadata of a parameter's key.

    The kernel has no other bounds than 0, and a limit may be missing.
    """
    lower = -LARGEST_DOUBLE if kind.minimum is None else 0.0
    if kind.above is not None or (kind.minimum or 0.0) > 0.0:
        lower = SMALLEST_DOUBLE
    return lower, math.inf if kind.number_for_none == math.inf else LARGEST_DOUBLE


@pytest.mark.parametrize("name", KINDS)
def test_a_parameter_has_the_range_of_its_key(name):
    kind = KINDS[name]
    path = tuple(map(str, kind.record_path[:2]))
    assert RANGES.get(path) == (None if path in OTHER_CHECKS else WIDER.get(path, range_of_key(kind)))


def units_in_comments():
    """Yield ((part, field), the comment that begins with the unit) for the fields of the record."""
    for file in Path(record.__file__).parent.glob("*.py"):
        part, comment_above = "", ""
        for line in file.read_text("utf-8").splitlines():
            if match := re.match(r"def (\w+)_dtype", line):
                part = match[1]
            if match := re.match(r'\s+\("(\w+)", [^#]*(?:# (.*))?$', line):
                yield (part, match[1]), match[2] or comment_above
            comment_above = (
                match[1] if (match := re.match(r"\s+# (.*)", line)) and not comment_above else comment_above
            )
            comment_above = comment_above if re.match(r"\s+# (?!----)", line) else ""


def test_the_comment_on_a_parameter_begins_with_the_unit_of_its_key():
    """A field that ends with a row for the slider has the unit of a joint or of the slider in its comment."""
    units, comments = defaultdict(set), dict(units_in_comments())
    for kind in KINDS.values():
        units[tuple(map(str, kind.record_path[:2]))].add(unit_text(kind.unit))
    wrong_comments = {
        path: comments[path]
        for path in units.keys() & comments.keys()
        if "" not in units[path] and comments[path].partition(",")[0] not in units[path]
    }
    assert len(units.keys() & comments.keys()) > 50
    assert wrong_comments == {}


def test_no_other_field_has_a_range():
    assert set(RANGED_PATHS) <= {tuple(map(str, kind.record_path[:2])) for kind in KINDS.values()}


def test_the_compiled_kernel_refuses_values_out_of_range_by_their_link():
    rod = {"length": 0.3, "mass": 1.0, "joint_max": 1.0}
    initial = {"position": [0.0, 0.0], "angles": [0.0] * 3}
    links = [rod | {"points": [{"x": 0.1, "y": 0.05}]}, rod, rod]
    instance = Instance(table(links, base="slider", initial=initial, box={"y_min": -9.0}))
    d, start = instance.record, instance.words.copy()
    of_links = 0
    for (part, field), (lower, _) in RANGES.items():
        given_name = f"given_{field}"
        field_of_part = d[part][[given_name if given_name in d[part].dtype.names else field]]
        name, shape = field_of_part.dtype.names[0], field_of_part[0].shape
        for value in (math.nan, -1.0) if lower >= 0.0 else (math.nan,):
            if 0 in shape:
                continue  # no signals
            instance.words[:] = start
            if shape:
                d[part][name][-1] = value
            else:
                d[part][name] = value
            with pytest.raises(SimulationError) as caught:
                instance.initialize()
            assert caught.value.status == PARAMETER_OUT_OF_RANGE, (part, field)
            if shape == (len(links),) and part != "walls":
                of_links += 1
                assert d["fault"]["part"] == 1 + d["candidate_count"] + len(links) - 1
    assert of_links > 10


def test_the_compiled_kernel_refuses_an_integer_beyond_its_bounds():
    rod = {"length": 0.3, "mass": 1.0, "joint_friction": 0.1, "joint_max": 1.0}
    signal = {"input": "joint[2].torque", "form": "ramp", "final": 1.0, "duration": 1.0}
    initial = {"position": [0.0, 0.0], "angles": [0.0] * 2}
    extra = {"inputs": {"joint_torques": True}, "signals": {"push": signal}}
    links = [{"length": 0.3, "mass": 1.0}, rod]
    instance = Instance(table(links, initial=initial, box={"y_min": -9.0}, **extra))
    d, start = Plain(instance.record), instance.words.copy()
    assert instance.is_sound(instance.words)
    checked = 0
    for k in range(len(BOUNDED_PATHS)):
        values = bounded_field(d, k)
        for number in (least_bound(d, k) - 1, most_bound(d, k) + 1) if len(values) else ():
            instance.words[:] = start
            part = d
            for name in BOUNDED_PATHS[k][:-1]:
                part = getattr(part, name)
            if np.ndim(part[BOUNDED_PATHS[k][-1]]):
                part[BOUNDED_PATHS[k][-1]][-1] = number
            else:
                part[BOUNDED_PATHS[k][-1]] = number
            assert not instance.is_sound(instance.words), BOUNDED_PATHS[k]
            checked += 1
    assert checked > len(BOUNDED_PATHS)
