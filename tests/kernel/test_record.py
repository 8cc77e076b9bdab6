"""The layout of an instance: the offsets of all fields in the record."""

# Tests: kernel/record/constants.py, kernel/record/operations.py
# Tests: kernel/record/counts.py, kernel/record/instance.py, kernel/record/method.py
# Tests: kernel/record/given.py, kernel/record/prescribed_motion.py
# Tests: kernel/record/friction.py, kernel/record/signals.py, kernel/record/solver.py

import ast
import itertools
import re
from collections import defaultdict
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.compilation import compilers
from chain_impact.kernel.record import fields
from chain_impact.kernel.record.constants import EXPLICIT, IMPLICIT
from chain_impact.kernel.record.counts import COUNTS, FEATURES
from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.record.instance import instance_dtype, output_dtype
from chain_impact.kernel.record.method import is_implicit, was_implicit
from chain_impact.variables.indices import HEAD_WORDS

# links N, candidates C, elements F, transmitted rows L, channels K, sites P
SIZES = [
    (1, 0, 0, 0),
    (1, 1, 0, 3),
    (1, 0, 1, 0),
    (2, 2, 4, 0),
    (4, 20, 0, 8),
    (7, 32, 39, 0),
    (2, 8, 0, 0, 2, 3),
]


def scalars(dtype):
    """Yield the offset [bytes] and the type of each scalar of a record."""
    if dtype.subdtype:
        item, shape = dtype.subdtype
        for i in range(int(np.prod(shape))):
            for offset, kind in scalars(item):
                yield i * item.itemsize + offset, kind
    elif dtype.fields:
        for inner, start, *_ in dtype.fields.values():
            for offset, kind in scalars(inner):
                yield start + offset, kind
    elif dtype == np.complex128:
        yield from ((0, dtype.type(0).real.dtype), (WORD, dtype.type(0).imag.dtype))
    else:
        yield 0, dtype


@pytest.mark.parametrize("sizes", SIZES)
def test_every_scalar_has_eight_bytes_and_none_lie_between_them(sizes):
    dtype = instance_dtype(*sizes)
    fields = list(scalars(dtype))
    assert {kind for _, kind in fields} == {np.dtype(np.float64), np.dtype(np.int64)}
    assert sorted(offset for offset, _ in fields) == list(range(0, dtype.itemsize, WORD))


@pytest.mark.parametrize("sizes", SIZES)
def test_the_output_record_is_the_row_of_a_time_series(sizes):
    assert instance_dtype(*sizes)["output"] == output_dtype(*sizes)


@pytest.mark.parametrize("rubbing", [False, True])
def test_the_size_grows_linearly(rubbing):
    small, middle, large = (
        instance_dtype(n, 4 * (n + 1), rubbing * (5 * n + 4)).itemsize for n in (10, 20, 30)
    )
    assert large - middle == middle - small


def test_without_dry_friction_there_is_no_room_for_it():
    for part in ("friction_element", "friction_changes"):
        sizes = [np.prod(dtype.shape) for dtype, *_ in instance_dtype(3, 12)[part].fields.values()]
        assert set(sizes) <= {0, 1}


def test_readers_of_the_sizes_have_the_order_of_the_record():
    head = list(instance_dtype(1, 0).names[:HEAD_WORDS])
    assert head == [*COUNTS, *FEATURES, "tangent_count"]
    assert [f"chain_{name}" for name in head[:-1]] == [*compilers._SIZES]
    assert len(COUNTS) + len(FEATURES) + 1 == HEAD_WORDS


# components have the unit of their vector; speeds of joints' stops are angular
ANY_UNIT = {"x", "y", "minimum_impact_speed"}
SYMBOL = r"√?(?:kg|rad|Hz|[msNJW1])(?:[²³]|\^(?:\w+|\([^)]*\)))?"
UNIT = re.compile(rf"{SYMBOL}(?:[·/]{SYMBOL})*(?=,| or |\])")


def declared_fields(source):
    """Yield the part, the name, the type and the comment of each field in a module with layouts."""
    lines = source.splitlines()
    for layout in ast.walk(ast.parse(source)):
        if not (isinstance(layout, ast.FunctionDef) and layout.name.endswith("_dtype")):
            continue
        for node in ast.walk(layout):
            match node:
                case ast.Tuple(elts=[ast.Constant(value=str(name)), kind, *_]) if name.isidentifier():
                    above = itertools.takewhile(
                        lambda line: line.strip().startswith("#"), reversed(lines[: node.lineno - 1])
                    )
                    _, _, beside = lines[node.end_lineno - 1][node.end_col_offset :].partition("#")
                    comment = beside or " ".join(line.strip(" #") for line in [*above][::-1])
                    yield layout.name.removesuffix("_dtype"), name, ast.unparse(kind), comment.strip()


def several_units(source):
    """Return the names of fields that have another unit or another kind of number in another part."""
    units_of = defaultdict(set)
    for _, name, kind, comment in declared_fields(source):
        start = re.match(rf"(?:{UNIT.pattern}(?:, | or )?)+", comment)
        units = UNIT.findall(" ".join([start[0] if start else "", *re.findall(r"\[.*?\]", comment)]))
        if kind.startswith(("INTEGER", "bounded_integer")):
            units = ["integer"]
        if units:
            units_of[name].add(frozenset(units))
    return sorted(name for name, all_units in units_of.items() if not frozenset.intersection(*all_units))


def test_the_same_field_name_has_the_same_unit_in_each_part():
    modules = sorted(Path(fields.__file__).parent.glob("*.py"))
    source = "\n".join(file.read_text("utf-8") for file in modules if file.name != "fields.py")
    assert {name for _, name, *_ in declared_fields(source)} > {*instance_dtype(1, 0)["contacts"].names}
    assert set(several_units(source)) == ANY_UNIT - {"y"}


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        ("REAL),  # m/s², a bound", ["reach"]),
        ("REAL),  # another length [m or s]", []),
        ("REAL),  # m or rad, a length", []),
        ("INTEGER),  # number of a link", ["reach"]),
        ("REAL),  # a ratio", []),
    ],
)
def test_another_unit_is_found(other, expected):
    declared = "def {}_dtype():\n    return layout(\n        {}\n    )\n".format
    chain_lines = declared("chain", '# m, the largest\n        # distance\n        ("reach", REAL),')
    assert several_units(chain_lines + declared("other", f'("reach", {other}')) == expected


def test_a_step_tells_its_method():
    d = SimpleNamespace(step=SimpleNamespace(method=EXPLICIT, last_method=IMPLICIT))
    assert (is_implicit(d), was_implicit(d)) == (False, True)
