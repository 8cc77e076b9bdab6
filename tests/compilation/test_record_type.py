"""The instance as a numba type: fields at NumPy's offsets, and results equal to plain Python's."""

# Tests: compilation/affine.py, compilation/built_in.py, compilation/entry_points.py, compilation/functions.py

import numpy as np
import pytest

from chain_impact.compilation.affine import SAMPLES, Affine, affine
from chain_impact.compilation.record_type import TABLES
from chain_impact.kernel.entry import observe_now, trajectory
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.record.counts import COUNTS, Counts
from chain_impact.kernel.record.fields import is_table
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.kernel.tangent.duals import tangent_dtype
from chain_impact.scene.scene import scene_from_dict, with_values
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.output_rows import spans_of
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.kernel.plain import Plain, as_plain_python
from tests.tiers import needs_compilers

pytestmark = needs_compilers

TABLE = TABLES["instance"]
LAYOUT = {"instance": lambda dtype: dtype, "tangent": tangent_dtype}


def number(affine, links, candidates, elements):
    counts = Counts(links, candidates, elements)
    return affine.constant + sum(slope * count for slope, count in zip(affine.slopes, counts, strict=True))


def per(affine, count):
    """Return by how much a size grows with a count, such as ``link_count``."""
    return affine.slopes[COUNTS.index(count)]


def places(dtype, path=(), offset=0):
    """Yield path, offset and type of every record, array and number of a record type."""
    yield path, offset, dtype
    if dtype.subdtype and is_table(dtype):
        for name, (field_type, start, *_) in dtype.base.fields.items():
            yield (*path, name), offset + start, np.dtype((field_type, dtype.shape))
    dual = dtype.names == ("value", "slope")
    for name, (field_type, start, *_) in ({} if dual else dtype.fields or {}).items():
        yield from places(field_type, (*path, name), offset + start)


@pytest.mark.parametrize(
    "sizes", [(1, 0, 0), (1, 0, 1), (1, 1, 0), (4, 20, 24), (10, 44, 0), (10, 44, 54), (64, 3, 67)]
)
@pytest.mark.parametrize("record_kind", TABLES)
def test_every_field_is_where_numpy_has_it(record_kind, sizes):
    table = TABLES[record_kind]
    found_places = list(places(LAYOUT[record_kind](instance_dtype(*sizes))))
    assert {path for path, *_ in found_places} == set(table)
    for path, offset, dtype in found_places:
        field = table[path]
        assert number(field.offset, *sizes) == offset, path
        shape = tuple(number(size, *sizes) for size in field.shape)
        if dtype.subdtype and is_table(dtype):
            # the number of rows is tested at the columns of the field
            assert (shape, dtype.base.names) == ((), field.fields), path
            assert {table[*path, name].stride for name in field.fields} == {dtype.base.itemsize}, path
        else:
            assert shape == dtype.shape, path
        if not field.stride:
            assert number(field.size, *sizes) == dtype.itemsize, path


def test_tables_of_candidates_and_elements_are_last_in_the_record():
    """Thus the offsets of all other fields are constants in a kernel for a fixed number of links."""
    for path in ("step", "scratch", "statistics", "friction"):
        for place, field in TABLE.items():
            if place[:1] == (path,):
                assert {
                    per(field.offset, count) for count in ("candidate_count", "friction_element_count")
                } == {0}
                assert {
                    per(field.size, count) for count in ("candidate_count", "friction_element_count")
                } == {0}
    assert per(TABLE["contacts", "active_count"].offset, "candidate_count") == 0
    for path in ("contacts", "law", "search", "contact_log"):
        assert per(TABLE[path,].offset, "friction_element_count") == 0
    parts_of_motions = (("given_channel",), ("channel",), ("wall_motion",), ("site",), ("signal",), ("knot",))
    for place, field in TABLE.items():
        if place[:1] not in ((), ("output",), ("transmitted",), *parts_of_motions):
            assert (per(field.offset, "transmitted_row_count"), per(field.size, "transmitted_row_count")) == (
                0,
                0,
            )


def test_a_size_that_is_not_affine_is_refused():
    other_sizes = [25] * (len(COUNTS) - 1)
    size = 25 + 11 * (SAMPLES[-1][0] - SAMPLES[0][0])
    with pytest.raises(ValueError, match=f"{size + 2}"):
        affine([25, 36, *other_sizes, size + 2])
    assert affine([25, 36, *other_sizes, size]) == Affine(
        25 - 11 * SAMPLES[0][0], (11, *[0] * len(other_sizes))
    )


def chain():
    """Return three links with damped joints and a motor that fall on a floor, next to a wall."""
    link = {"length": 0.3, "mass": 0.5, "joint_damping": 0.02}
    start = {"position": [0.05, 0.5], "angles": [0.3, -0.6, 0.2], "angular_velocities": [1.0, -3.0, 2.0]}
    table = {"name": "Chain", "gravity": [-1.0, -9.81], "chain": {"links": [link] * 3}, "initial": start}
    inputs = {"joint_torques": True, "tip_force": True}
    return scene_from_dict(table | {"box": {"x_min": 0.0, "y_min": 0.0}, "inputs": inputs}, "chain")


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {("contact", "model"): "newton_impact"},
        {("contact", "model"): "kelvin_voigt", ("contact", "exponent"): 1.0},
        {("solver", "method"): "implicit", ("contact", "stiffness"): 1e5},
        {("chain", "links", 1, "joint_damping"): 100.0, ("solver", "tolerance"): 1e-5},
    ],
    ids=["explicit", "rigid", "with a jump", "implicit", "a stiff joint"],
)
def test_compiled_code_gives_the_bits_of_plain_python(changes):
    """Lowering and linking change no rounding of the whole kernel through impacts."""
    scene = with_values(chain(), changes)
    times = np.array([0.2, 0.28, 0.2801, 0.33, 0.37, 0.4])
    instance = Instance(scene)
    rows = np.zeros(len(times), instance.record.dtype["output"])
    assert instance.trajectory(times, rows) == len(times)
    memory = PreparedScene(scene).new_instance()
    d = Plain(memory[0])
    plain_rows = np.zeros_like(rows)
    with as_plain_python(), np.errstate(all="ignore"):
        assert initialize(d, 0.0) == 0
        words, spans = memory.view(np.float64), spans_of(instance.prepared_scene.output_words)
        row_words = plain_rows.view(np.float64).reshape(len(times), -1)
        assert trajectory(d, words, times, spans, row_words, 0) == len(times)
        assert observe_now(d) == 0
    assert d.impact.count == instance.record["impact"]["count"] >= 1
    assert plain_rows.tobytes() == rows.tobytes()
    assert d.numpy_record["statistics"] == instance.record["statistics"]
