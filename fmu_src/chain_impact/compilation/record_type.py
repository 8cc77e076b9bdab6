"""The instance as a numba type: one lowering of the kernel serves every number of links and candidates.

numba's own record types contain all sizes. Code for this type gets the numbers of links, candidates and so on
(kernel/record/counts.py), and two flags, by calls of functions that are defined when a kernel is linked
(compilers.py): as constants, or as numbers that the instance holds. All sizes and offsets follow from these
numbers.

A value of this type is the address of the instance. The type says which record or field of the instance is
meant, and whether its reals are ordinary or dual numbers (dual_numbers.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from llvmlite import ir
from numba import from_dtype, types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    register_model,
    type_callable,
)

from chain_impact.compilation.affine import SAMPLES, Affine, affine
from chain_impact.compilation.dual_numbers import DUAL
from chain_impact.kernel import functions
from chain_impact.kernel.record.counts import COUNTS, FEATURES
from chain_impact.kernel.record.fields import REAL, SETTABLE, is_table
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.kernel.tangent import duals
from chain_impact.kernel.tangent.duals import dual_dtype, tangent_dtype

# count in an instance, such as ``links`` → name of the function that returns this count
COUNTERS = {name: f"chain_{name}" for name in COUNTS}
# flag in an instance, such as ``slides`` → name of the function that returns this flag; no size depends on it
FEATURE_FUNCTIONS = {name: f"chain_{name}" for name in FEATURES}
WORD = 8  # [byte] size of every scalar

Path = tuple[str, ...]


@dataclass(frozen=True)
class Field:
    """A part of the instance.

    Attributes:
        offset: bytes from the start of the instance.
        size: number of bytes.
        fields: the parts of a record; none for a number or an array.
        kind: numba's type of a number or of the entries of an array.
        shape: the shape of an array.
        stride: bytes from one entry of a table's column to the next; 0 for an array without gaps.
    """

    offset: Affine
    size: Affine
    fields: Sequence[str]
    kind: types.Type
    shape: Sequence[Affine]
    stride: int = 0


def _kind(dtype: np.dtype) -> types.Type:
    """Return numba's type of a number, or of the entries of an array."""
    return DUAL if dtype == dual_dtype(np.dtype(REAL)) else from_dtype(dtype)


def _table(layouts: Sequence[np.dtype]) -> dict[Path, Field]:
    """Return every part of the instance by path, from the layouts with the sizes of ``SAMPLES``."""
    table: dict[Path, Field] = {}

    def add(path: Path, dtypes: Sequence[Any], offsets: Sequence[int]) -> None:
        first_dtype = dtypes[0]
        if first_dtype.subdtype and is_table(first_dtype):
            add_columns(path, dtypes, offsets)
            return
        kind = _kind(first_dtype.base)
        fields = () if kind == DUAL else first_dtype.names or ()
        table[path] = Field(
            offset=affine(offsets),
            size=affine([dtype.itemsize for dtype in dtypes]),
            fields=fields,
            kind=kind,
            shape=[affine(sizes) for sizes in zip(*(dtype.shape for dtype in dtypes), strict=True)],
        )
        for name in fields:
            inner, starts, *_ = zip(*(dtype.fields[name] for dtype in dtypes), strict=True)
            add((*path, name), inner, [sum(pair) for pair in zip(offsets, starts, strict=True)])

    def add_columns(path: Path, dtypes: Sequence[Any], offsets: Sequence[int]) -> None:
        """Add a table of the instance as a record; each field of this record is a column of the table."""
        row = dtypes[0].base
        shape = [affine(sizes) for sizes in zip(*(dtype.shape for dtype in dtypes), strict=True)]
        size = affine([dtype.itemsize for dtype in dtypes])
        table[path] = Field(affine(offsets), size, row.names, types.none, ())
        for name in row.names:
            kind, start = row.fields[name][:2]
            column_offset = affine([offset + start for offset in offsets])
            table[*path, name] = Field(column_offset, size, (), _kind(kind), shape, row.itemsize)

    add((), layouts, [0] * len(layouts))
    return table


LAYOUTS = [instance_dtype(*sample) for sample in SAMPLES]
TABLES = {"instance": _table(LAYOUTS), "tangent": _table([tangent_dtype(layout) for layout in LAYOUTS])}


class Record(types.Type):
    """numba's type of an instance, or of a record in an instance.

    Attributes:
        what: a key of ``TABLES``: an instance of ordinary numbers, or of dual numbers.
        path: the path of the record.
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
    """numba's rule for the types of a record's fields."""

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


def _built(number: Affine, builder: ir.IRBuilder, instance: ir.Value) -> ir.Value:
    """Return the LLVM value of an affine number: a constant plus factors times counts of the instance."""
    total: ir.Value = cgutils.intp_t(number.constant)
    for factor, name in zip(number.slopes, COUNTERS.values(), strict=True):
        if factor:
            count = builder.call(_counter(builder, name), [instance])
            total = builder.add(total, builder.mul(count, cgutils.intp_t(factor)))
    return total


def _counter(builder: ir.IRBuilder, name: str) -> ir.Function:
    kind = ir.FunctionType(cgutils.intp_t, [cgutils.voidptr_t])
    return cgutils.get_or_insert_function(builder.module, kind, name)


def _address(context: Any, builder: ir.IRBuilder, instance: ir.Value, field: Field) -> ir.Value:
    """Return the address of a field, as a pointer to numbers."""
    kind = context.get_data_type(types.float64 if field.fields else field.kind).as_pointer()
    return cgutils.pointer_add(builder, instance, _built(field.offset, builder, instance), kind)


@lower_getattr_generic(Record)
def _get_field(context: Any, builder: ir.IRBuilder, record: Record, instance: ir.Value, name: str) -> Any:
    field = record.field(name)
    if field.fields:
        return instance
    if record.path == () and (counter := (COUNTERS | FEATURE_FUNCTIONS).get(name)):
        return builder.call(_counter(builder, counter), [instance])
    address = _address(context, builder, instance, field)
    if field.shape:
        shape = [_built(size, builder, instance) for size in field.shape]
        return _array(context, builder, field.kind, address, shape, stride=field.stride)
    return context.unpack_value(builder, field.kind, address)


def _array(
    context: Any,
    builder: ir.IRBuilder,
    scalar: types.Type,
    first: ir.Value,
    shape: Sequence[ir.Value],
    *,
    stride: int = 0,
) -> ir.Value:
    """Return an array that does not own its memory, from the address of its first entry.

    The array has no gaps, or the distance ``stride`` [bytes] between successive entries.
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
    record, given = signature.args
    instance, value = arguments
    field = record.field(name)
    value = context.cast(builder, value, given, field.kind)
    context.pack_value(builder, field.kind, value, _address(context, builder, instance, field))


@type_callable(duals.block)
def _type_of_block(_context: Any) -> Any:
    def typer(instance: types.Type, _number: types.Type) -> types.Type | None:
        return TANGENT if instance == INSTANCE else None

    return typer


@lower_builtin(duals.block, Record, types.Integer)
def _block(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    instance, number = arguments
    primal_size, tangent_size = (
        _built(record.field().size, builder, instance) for record in (INSTANCE, TANGENT)
    )
    number = context.cast(builder, number, signature.args[1], types.int64)
    return cgutils.pointer_add(
        builder, instance, builder.add(primal_size, builder.mul(tangent_size, number)), instance.type
    )


@type_callable(duals.as_words)
def _type_of_words(_context: Any) -> Any:
    def typer(record: types.Type) -> types.Type | None:
        return types.Array(types.float64, 1, "C") if isinstance(record, Record) else None

    return typer


@lower_builtin(duals.as_words, Record)
def _words(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    (instance,) = arguments
    whole = signature.args[0].field()
    size = builder.udiv(_built(whole.size, builder, instance), cgutils.intp_t(WORD))
    return _array(context, builder, types.float64, _address(context, builder, instance, whole), [size])


@type_callable(functions.clear)
def _type_of_clear(_context: Any) -> Any:
    def typer(record: types.Type) -> types.Type | None:
        return types.none if isinstance(record, Record) else None

    return typer


@lower_builtin(functions.clear, Record)
def _clear(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    (instance,) = arguments
    part = signature.args[0].field()
    address = _address(context, builder, instance, part)
    cgutils.memset(builder, address, _built(part.size, builder, instance), 0)
    return context.get_dummy_value()


@type_callable(functions.copy_row)
def _type_of_copy_row(_context: Any) -> Any:
    def typer(table: types.Type, _source: types.Type, _row: types.Type) -> types.Type | None:
        return types.none if isinstance(table, Record) else None

    return typer


@lower_builtin(functions.copy_row, Record, types.Integer, types.Integer)
def _copy_row(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    instance, *numbers = arguments
    table, *kinds = signature.args
    rows = [context.cast(builder, *pair, types.int64) for pair in zip(numbers, kinds, strict=True)]
    for name in table.field().fields:
        column = table.field(name)
        first, stride = _address(context, builder, instance, column), cgutils.intp_t(column.stride)
        source, target = (
            cgutils.pointer_add(builder, first, builder.mul(row, stride), first.type) for row in rows
        )
        builder.store(builder.load(source), target)
    return context.get_dummy_value()


@type_callable(duals.copy_values)
def _type_of_copy_values(_context: Any) -> Any:
    def typer(source: types.Type, target: types.Type) -> types.Type | None:
        return types.none if _has_dual(source, target) else None

    return typer


@type_callable(duals.copy_given)
def _type_of_copy_given(_context: Any) -> Any:
    def typer(source: types.Type, target: types.Type, when: types.Type) -> types.Type | None:
        # numba asks first with the type of ``when``, then with its constant value; only the second is
        # answered
        return types.none if _has_dual(source, target) and isinstance(when, types.Literal) else None

    return typer


def _has_dual(source: types.Type, target: types.Type) -> bool:
    """Return whether ``target`` is the part of an instance of dual numbers that corresponds to ``source``.

    ``source`` must be a part of an instance of ordinary numbers.
    """
    if not (isinstance(source, Record) and isinstance(target, Record) and source.path == target.path):
        return False
    return (source.what, target.what) == ("instance", "tangent")


@lower_builtin(duals.copy_values, Record, Record)
def _copy_values(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    part = signature.args[0].path
    _copy_fields(context, builder, arguments, lambda path: path[: len(part)] == part)
    return context.get_dummy_value()


@lower_builtin(duals.copy_given, Record, Record, types.Integer)
def _copy_given(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    when = signature.args[2].literal_value
    _copy_fields(context, builder, arguments[:2], lambda path: SETTABLE.get(path[0]) == when)
    return context.get_dummy_value()


def _copy_fields(
    context: Any, builder: ir.IRBuilder, instances: Sequence[ir.Value], wanted: Callable[[Path], bool]
) -> None:
    """Copy the values of the wanted fields of an instance to an instance of dual numbers."""
    source, target = instances
    for path, field in TABLES["instance"].items():
        if path and wanted(path) and not field.fields:
            word = context.get_data_type(field.kind)
            count: ir.Value = cgutils.intp_t(1)
            for size in field.shape:
                count = builder.mul(count, _built(size, builder, source))
            source_words, source_step = _words_of(context, builder, source, field, word)
            target_words, target_step = _words_of(context, builder, target, TABLES["tangent"][path], word)
            with cgutils.for_range(builder, count) as loop:
                number = builder.load(builder.gep(source_words, [builder.mul(loop.index, source_step)]))
                builder.store(number, builder.gep(target_words, [builder.mul(loop.index, target_step)]))


def _words_of(
    context: Any, builder: ir.IRBuilder, instance: ir.Value, field: Field, word: ir.Type
) -> tuple[ir.Value, ir.Value]:
    """Return the address of a field's first value, and the number of words between successive values."""
    words = context.get_abi_sizeof(context.get_data_type(field.kind)) // WORD
    address = builder.bitcast(_address(context, builder, instance, field), word.as_pointer())
    return address, cgutils.intp_t(words)


def _numbers(first: types.CPointer, *counts: types.Integer) -> Any:
    """Return the signature and the code for an array of numbers, from its first address and its shape."""
    scalar = first.dtype

    def code(context: Any, builder: ir.IRBuilder, _signature: Any, arguments: Any) -> Any:
        first, *shape = arguments
        return _array(context, builder, scalar, first, shape)

    return types.Array(scalar, len(counts), "C")(first, *counts), code


@intrinsic
def vector(_context: Any, first: types.CPointer, count: types.Integer) -> Any:
    """Return an array of numbers, shape (count,), from the address of its first number."""
    return _numbers(first, count)


@intrinsic
def matrix(_context: Any, first: types.CPointer, rows: types.Integer, columns: types.Integer) -> Any:
    """Return an array of numbers, shape (rows, columns), from the address of its first number."""
    return _numbers(first, rows, columns)
