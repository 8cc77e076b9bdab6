"""Code for numba in place of the Python code of functions that find, copy or clear parts of a record.

A function named _type_of_… tells numba the type of the result of such a function; a function with the
decorator ``lower_builtin`` writes the LLVM code of such a function.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import lower_builtin, type_callable

from chain_impact.compilation.affine import SAMPLES, Affine, affine
from chain_impact.compilation.numba_parts import cgutils
from chain_impact.compilation.record_type import (
    INSTANCE,
    TABLES,
    TANGENT,
    Field,
    Path,
    Record,
    address_of,
    affine_value,
    array_at,
)
from chain_impact.kernel.record import input_fields, operations, ranges
from chain_impact.kernel.record.fields import SETTABLE, WORD
from chain_impact.kernel.tangent import duals

FUNCTIONS: set[Any] = {
    *(duals.tangent_instance, duals.as_words, duals.copy_values, duals.copy_given),
    *(operations.clear_numbers, operations.copy_row, input_fields.input_field),
    *(ranges.ranged_field, ranges.bounded_field, ranges.least_bound, ranges.most_bound),
}
"""The functions of the kernel for which this module gives numba the code."""


@type_callable(input_fields.input_field)
def _type_of_input(_context: Any) -> Any:
    def typer(part: types.Type, _number: types.Type) -> types.Type | None:
        if not isinstance(part, Record):
            return None
        first, *_ = _inputs(part)
        return types.Array(first.kind, len(first.shape), "C")

    return typer


def _inputs(part: Record) -> list[Field]:
    return [part.field(name) for name in input_fields.INPUT_SIZES]


@lower_builtin(input_fields.input_field, Record, types.Integer)
def _lower_input(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    instance, given_number = arguments
    part, kind = signature.args
    number = context.cast(builder, given_number, kind, types.intp)
    fields = _inputs(part)

    def address_and_shape(field: Field) -> list[ir.Value]:
        sizes = [affine_value(size, builder, instance) for size in field.shape]
        return [address_of(context, builder, instance, field), *sizes]

    address, *shape = _choose_value(builder, number, [partial(address_and_shape, field) for field in fields])
    return array_at(context, builder, fields[0].kind, address, shape)


def _choose_value(
    builder: ir.IRBuilder, number: ir.Value, makers: Sequence[Callable[[], list[ir.Value]]]
) -> list[ir.Value]:
    """Return the LLVM values that ``makers[number]`` makes; those of ``makers[0]`` for a number out of range.

    ``number`` is known only when the code runs, so the code of all makers is written into a switch.
    """
    blocks = [builder.append_basic_block() for _ in makers]
    end = builder.append_basic_block()
    choice = builder.switch(number, blocks[0])
    made_values = []
    for k, (block, make) in enumerate(zip(blocks, makers, strict=True)):
        choice.add_case(cgutils.intp_t(k), block)
        builder.position_at_end(block)
        made_values.append((make(), builder.block))
        builder.branch(end)
    builder.position_at_end(end)
    chosen_values = []
    for values in zip(*(values for values, _ in made_values), strict=True):
        chosen_values.append(builder.phi(values[0].type))
        for value, (_, block) in zip(values, made_values, strict=True):
            chosen_values[-1].add_incoming(value, block)
    return chosen_values


def _give_field(function: Callable[..., Any], paths: Sequence[Path], kind: types.Type) -> None:
    """Give numba the code of a function of (instance, k) that returns the field ``paths[k]`` as an array.

    The array has one dimension, without a copy of the numbers, which are of the type ``kind`` in all fields.
    """

    @type_callable(function)
    def _type_of_field(_context: Any) -> Any:
        def typer(instance: types.Type, _number: types.Type) -> types.Type | None:
            return types.Array(kind, 1, "C") if isinstance(instance, Record) else None

        return typer

    @lower_builtin(function, Record, types.Integer)
    def _field(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
        instance, number = arguments
        number = context.cast(builder, number, signature.args[1], types.intp)

        def address_and_count(path: Path) -> list[ir.Value]:
            field = signature.args[0].field(*path)
            assert field.kind == kind
            assert not field.stride, f"{'.'.join(path)} is a column of a table"
            count = builder.udiv(affine_value(field.size, builder, instance), cgutils.intp_t(WORD))
            return [address_of(context, builder, instance, field), count]

        address, count = _choose_value(builder, number, [partial(address_and_count, path) for path in paths])
        return array_at(context, builder, kind, address, [count])


def _give_bound(function: Callable[..., Any], bounds: Sequence[Affine]) -> None:
    """Give numba the code of a function of (instance, k) that returns the bound ``bounds[k]``.

    A bound is the least or the largest value that field k of ``ranges.BOUNDED_PATHS`` may have, an affine
    function of the counts of the instance.
    """

    @type_callable(function)
    def _type_of_bound(_context: Any) -> Any:
        def typer(instance: types.Type, _number: types.Type) -> types.Type | None:
            return types.int64 if isinstance(instance, Record) else None

        return typer

    @lower_builtin(function, Record, types.Integer)
    def _bound(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
        instance, number = arguments
        number = context.cast(builder, number, signature.args[1], types.intp)
        makers = [partial(lambda bound: [affine_value(bound, builder, instance)], bound) for bound in bounds]
        (chosen_bound,) = _choose_value(builder, number, makers)
        return chosen_bound


_give_field(ranges.ranged_field, ranges.RANGED_PATHS, types.float64)
_give_field(ranges.bounded_field, ranges.BOUNDED_PATHS, types.int64)
_BOUNDS = [zip(*pairs, strict=True) for pairs in zip(*map(ranges.bounds_of, SAMPLES), strict=True)]
_LEAST_BOUNDS, _MOST_BOUNDS = zip(
    *([affine(numbers) for numbers in bounds] for bounds in _BOUNDS), strict=True
)
_give_bound(ranges.least_bound, _LEAST_BOUNDS)
_give_bound(ranges.most_bound, _MOST_BOUNDS)


@type_callable(duals.tangent_instance)
def _type_of_block(_context: Any) -> Any:
    def typer(instance: types.Type, _number: types.Type) -> types.Type | None:
        return TANGENT if instance == INSTANCE else None

    return typer


@lower_builtin(duals.tangent_instance, Record, types.Integer)
def _lower_block(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    instance, number = arguments
    primal_size, tangent_size = (
        affine_value(record.field().size, builder, instance) for record in (INSTANCE, TANGENT)
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
def _lower_words(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    (instance,) = arguments
    field = signature.args[0].field()
    size = builder.udiv(affine_value(field.size, builder, instance), cgutils.intp_t(WORD))
    return array_at(context, builder, types.float64, address_of(context, builder, instance, field), [size])


@type_callable(operations.clear_numbers)
def _type_of_clear(_context: Any) -> Any:
    def typer(record: types.Type) -> types.Type | None:
        return types.none if isinstance(record, Record) else None

    return typer


@lower_builtin(operations.clear_numbers, Record)
def _lower_clear(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    (instance,) = arguments
    part = signature.args[0].field()
    address = address_of(context, builder, instance, part)
    cgutils.memset(builder, address, affine_value(part.size, builder, instance), 0)
    return context.get_dummy_value()


@type_callable(operations.copy_row)
def _type_of_copy_row(_context: Any) -> Any:
    def typer(table: types.Type, _source: types.Type, _row: types.Type) -> types.Type | None:
        return types.none if isinstance(table, Record) else None

    return typer


@lower_builtin(operations.copy_row, Record, types.Integer, types.Integer)
def _lower_copy_row(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    instance, *numbers = arguments
    table, *kinds = signature.args
    rows = [context.cast(builder, *pair, types.int64) for pair in zip(numbers, kinds, strict=True)]
    for name in table.field().fields:
        column = table.field(name)
        first, stride = address_of(context, builder, instance, column), cgutils.intp_t(column.stride)
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
        # numba asks for the type of the result twice: first with the type of ``when``, then with the constant
        # value of ``when``. Only the second call gets a result, because the code depends on the value.
        return types.none if _has_dual(source, target) and isinstance(when, types.Literal) else None

    return typer


def _has_dual(source: types.Type, target: types.Type) -> bool:
    """Return whether the types are those of a part of an instance and the same part of a tangent instance.

    ``source`` is the type in the instance, ``target`` the type in the tangent instance.
    """
    if not (isinstance(source, Record) and isinstance(target, Record) and source.path == target.path):
        return False
    return (source.what, target.what) == ("instance", "tangent")


@lower_builtin(duals.copy_values, Record, Record)
def _lower_copy_values(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    part = signature.args[0].path
    _copy_fields(context, builder, arguments, lambda path: path[: len(part)] == part)
    return context.get_dummy_value()


@lower_builtin(duals.copy_given, Record, Record, types.Integer)
def _lower_copy_given(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> ir.Value:
    when = signature.args[2].literal_value
    _copy_fields(context, builder, arguments[:2], lambda path: SETTABLE.get(path[0]) == when)
    return context.get_dummy_value()


def _copy_fields(
    context: Any, builder: ir.IRBuilder, instances: Sequence[ir.Value], is_wanted: Callable[[Path], bool]
) -> None:
    """Write code that copies the values of fields to a tangent instance, whose derivatives stay.

    ``instances`` are the addresses of an instance and of the tangent instance. ``is_wanted`` is a function
    from the path of a field to whether the field is copied.
    """
    source, target = instances
    for path, field in TABLES["instance"].items():
        if path and is_wanted(path) and not field.fields:
            word = context.get_data_type(field.kind)
            count: ir.Value = cgutils.intp_t(1)
            for size in field.shape:
                count = builder.mul(count, affine_value(size, builder, source))
            source_words, source_step = _words_of(context, builder, source, field, word)
            target_words, target_step = _words_of(context, builder, target, TABLES["tangent"][path], word)
            with cgutils.for_range(builder, count) as loop:
                number = builder.load(builder.gep(source_words, [builder.mul(loop.index, source_step)]))
                builder.store(number, builder.gep(target_words, [builder.mul(loop.index, target_step)]))


def _words_of(
    context: Any, builder: ir.IRBuilder, instance: ir.Value, field: Field, word: ir.Type
) -> tuple[ir.Value, ir.Value]:
    """Return the address of a field's first value, and the number of words of 8 bytes from value to value.

    The values are numbers of the type ``word``. A dual number takes several words; the first is its value.
    """
    words = context.get_abi_sizeof(context.get_data_type(field.kind)) // WORD
    address = builder.bitcast(address_of(context, builder, instance, field), word.as_pointer())
    return address, cgutils.intp_t(words)
