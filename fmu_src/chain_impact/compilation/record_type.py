"""numba's type of an instance, which fixes no size: the kernel is lowered once for all numbers of links.

numba's own record types contain all sizes. Code for this type gets the counts of links, candidates and so on
(kernel/record/counts.py), and two flags, from functions that are added when a kernel is compiled
(compilers.py); these return constants, or numbers of the record. All sizes and offsets follow from the
counts.

A value of this type is the address of the instance. The type tells which record of the instance is meant, and
whether its real numbers are ordinary or dual (dual_numbers.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from llvmlite import ir
from numba import from_dtype, types
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    register_model,
)

from chain_impact.compilation.affine import SAMPLES, Affine, affine
from chain_impact.compilation.dual_numbers import DUAL
from chain_impact.compilation.numba_parts import AttributeTemplate, cgutils
from chain_impact.kernel.record.counts import COUNTS, FEATURES
from chain_impact.kernel.record.fields import REAL, is_table
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.kernel.tangent.duals import dual_dtype, tangent_dtype

# name of a count in an instance, such as ``link_count`` → name of the LLVM function that returns it
COUNT_FUNCTIONS = {name: f"chain_{name}" for name in COUNTS}
# name of a flag in an instance, such as ``slides`` → name of the LLVM function that returns the flag; no size
# depends on flags
FEATURE_FUNCTIONS = {name: f"chain_{name}" for name in FEATURES}

Path = tuple[str, ...]


@dataclass(frozen=True)
class Field:
    """A part of an instance: a record, a number or an array.

    Attributes:
        offset: distance from the start of the instance to the start of the part [byte].
        size: size of the part [byte]; for a column of a table, the size of the whole table.
        fields: the names of a record's parts; empty for a number or an array.
        kind: numba's type of the number, or of the entries of the array.
        shape: the shape of the array; empty for a number or a record.
        stride: distance from an entry to the next in a column of a table [byte]; 0 for an array without gaps.

    ``offset``, ``size`` and ``shape`` are affine functions of the counts.
    """

    offset: Affine
    size: Affine
    fields: Sequence[str]
    kind: types.Type
    shape: Sequence[Affine]
    stride: int = 0


def _numba_type(dtype: np.dtype) -> types.Type:
    """Return numba's type of a number, or of the entries of an array."""
    return DUAL if dtype == dual_dtype(np.dtype(REAL)) else from_dtype(dtype)


def _fields_by_path(layouts: Sequence[np.dtype]) -> dict[Path, Field]:
    """Return path → part, for all parts of an instance, from the types of records with the counts SAMPLES."""
    table: dict[Path, Field] = {}

    def add(path: Path, dtypes: Sequence[Any], offsets: Sequence[int]) -> None:
        first_dtype = dtypes[0]
        if first_dtype.subdtype and is_table(first_dtype):
            add_columns(path, dtypes, offsets)
            return
        kind = _numba_type(first_dtype.base)
        fields = () if kind == DUAL else first_dtype.names or ()
        table[path] = Field(
            offset=affine(offsets),
            size=affine([dtype.itemsize for dtype in dtypes]),
            fields=fields,
            kind=kind,
            shape=[affine(sizes) for sizes in zip(*(dtype.shape for dtype in dtypes), strict=True)],
        )
        for name in fields:
            field_dtypes, starts, *_ = zip(*(dtype.fields[name] for dtype in dtypes), strict=True)
            add((*path, name), field_dtypes, [sum(pair) for pair in zip(offsets, starts, strict=True)])

    def add_columns(path: Path, dtypes: Sequence[Any], offsets: Sequence[int]) -> None:
        """Add the array of records at ``path`` to the result, as one record whose fields are the columns."""
        row = dtypes[0].base
        shape = [affine(sizes) for sizes in zip(*(dtype.shape for dtype in dtypes), strict=True)]
        size = affine([dtype.itemsize for dtype in dtypes])
        table[path] = Field(affine(offsets), size, row.names, types.none, ())
        for name in row.names:
            kind, start = row.fields[name][:2]
            column_offset = affine([offset + start for offset in offsets])
            table[*path, name] = Field(column_offset, size, (), _numba_type(kind), shape, row.itemsize)

    add((), layouts, [0] * len(layouts))
    return table


LAYOUTS = [instance_dtype(*sample) for sample in SAMPLES]
TABLES = {
    "instance": _fields_by_path(LAYOUTS),
    "tangent": _fields_by_path([tangent_dtype(layout) for layout in LAYOUTS]),
}


class Record(types.Type):
    """numba's type of an instance, or of a record in an instance.

    Attributes:
        what: a key of ``TABLES``: "instance" for ordinary numbers, "tangent" for dual numbers.
        path: the path of the record in the instance; empty for the instance itself.
    """

    def __init__(self, what: str, path: Path = ()) -> None:
        self.what, self.path = what, path
        super().__init__(name=".".join((what, *path)))

    def field(self, *names: str) -> Field:
        """Return a part of the record; raise a KeyError if the record has no such part."""
        return TABLES[self.what][*self.path, *names]


register_model(Record)(models.OpaqueModel)
INSTANCE, TANGENT = Record("instance"), Record("tangent")


@infer_getattr
class _Fields(AttributeTemplate):
    """Tells numba the types of a record's fields."""

    key = Record

    def generic_resolve(self, record: Record, name: str) -> types.Type | None:
        """Return the type of a field; None if the record has no such field."""
        try:
            field = record.field(name)
        except KeyError:
            return None
        if field.fields:
            return Record(record.what, (*record.path, name))
        layout = "A" if field.stride else "C"
        return types.Array(field.kind, len(field.shape), layout) if field.shape else field.kind


def affine_value(number: Affine, builder: ir.IRBuilder, instance: ir.Value) -> ir.Value:
    """Return the LLVM value of an affine function of the counts of an instance."""
    total: ir.Value = cgutils.intp_t(number.constant)
    for factor, name in zip(number.slopes, COUNT_FUNCTIONS.values(), strict=True):
        if factor:
            count = builder.call(_count_function(builder, name), [instance])
            total = builder.add(total, builder.mul(count, cgutils.intp_t(factor)))
    return total


def _count_function(builder: ir.IRBuilder, name: str) -> ir.Function:
    kind = ir.FunctionType(cgutils.intp_t, [cgutils.voidptr_t])
    return cgutils.get_or_insert_function(builder.module, kind, name)


def address_of(context: Any, builder: ir.IRBuilder, instance: ir.Value, field: Field) -> ir.Value:
    """Return the address of a part of an instance, as a pointer to the first number of the part."""
    kind = context.get_data_type(types.float64 if field.fields else field.kind).as_pointer()
    return cgutils.pointer_add(builder, instance, affine_value(field.offset, builder, instance), kind)


@lower_getattr_generic(Record)
def _get_field(context: Any, builder: ir.IRBuilder, record: Record, instance: ir.Value, name: str) -> Any:
    field = record.field(name)
    if field.fields:
        return instance
    if record.path == () and (function := (COUNT_FUNCTIONS | FEATURE_FUNCTIONS).get(name)):
        return builder.call(_count_function(builder, function), [instance])
    address = address_of(context, builder, instance, field)
    if field.shape:
        shape = [affine_value(size, builder, instance) for size in field.shape]
        return array_at(context, builder, field.kind, address, shape, stride=field.stride)
    return context.unpack_value(builder, field.kind, address)


def array_at(
    context: Any,
    builder: ir.IRBuilder,
    scalar: types.Type,
    first: ir.Value,
    shape: Sequence[ir.Value],
    *,
    stride: int = 0,
) -> ir.Value:
    """Return a numba array over memory that the array does not own.

    ``first`` is the address of the first entry, ``scalar`` the type of an entry. The entries follow each
    other without gaps if ``stride`` is 0, else at the distance ``stride`` [byte], as in a column of a table.
    """
    array = cgutils.create_struct_proxy(types.Array(scalar, len(shape), "A" if stride else "C"))(
        context, builder
    )
    strides: list[ir.Value] = []
    word = cgutils.intp_t(context.get_abi_sizeof(context.get_data_type(scalar)))
    step: ir.Value = cgutils.intp_t(stride) if stride else word
    for size in reversed(shape):
        strides.insert(0, step)
        step = builder.mul(step, size)
    array.meminfo = cgutils.get_null_value(array.meminfo.type)
    array.parent = cgutils.get_null_value(array.parent.type)
    array.nitems = builder.udiv(step, strides[-1])
    array.itemsize, array.data = word, first
    array.shape, array.strides = cgutils.pack_array(builder, shape), cgutils.pack_array(builder, strides)
    return array._getvalue()


@lower_setattr_generic(Record)
def _set_field(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any, name: str) -> None:
    record, given_type = signature.args
    instance, value = arguments
    field = record.field(name)
    value = context.cast(builder, value, given_type, field.kind)
    context.pack_value(builder, field.kind, value, address_of(context, builder, instance, field))


def _array_maker(first: types.CPointer, *counts: types.Integer) -> Any:
    """Return signature and code, for numba, of a function that makes an array over memory.

    ``first`` and ``counts`` are the types of the function's arguments: the address of the first number, and
    the number of entries in each dimension.
    """
    scalar = first.dtype

    def code(context: Any, builder: ir.IRBuilder, _signature: Any, arguments: Any) -> Any:
        first, *shape = arguments
        return array_at(context, builder, scalar, first, shape)

    return types.Array(scalar, len(counts), "C")(first, *counts), code


@intrinsic
def vector(_context: Any, first: types.CPointer, count: types.Integer) -> Any:
    """Return an array of numbers, shape (count,), from the address of its first number."""
    return _array_maker(first, count)


@intrinsic
def matrix(_context: Any, first: types.CPointer, rows: types.Integer, columns: types.Integer) -> Any:
    """Return an array of numbers, shape (rows, columns), from the address of its first number."""
    return _array_maker(first, rows, columns)
