"""Dual numbers as a numba type: a value with its derivatives in several directions.

A function of the kernel that is compiled for dual numbers gives exact derivatives with its values: each
operation also computes the derivatives of its result by the chain rule. The values are the same, bit for bit,
as without derivatives. Comparisons use only the values. The derivatives of one number form a vector, so that
the processor computes several derivatives at once.

Source: W. K. Clifford 1873, Preliminary sketch of biquaternions, Proc London Math Soc 4:381; for derivatives
A. Griewank and A. Walther 2008, Evaluating Derivatives, SIAM, chapter 3.
"""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba import boolean, float64, types
from numba.extending import lower_builtin, lower_cast, models, register_model

from chain_impact.compilation.numba_parts import (
    AbstractTemplate,
    Conversion,
    cgutils,
    infer_global,
    signature,
)
from chain_impact.kernel.tangent import duals
from chain_impact.kernel.tangent.duals import DIRECTIONS

VECTOR = ir.VectorType(ir.DoubleType(), DIRECTIONS)


class Dual(types.Type):
    """numba's type of a dual number."""

    def __init__(self) -> None:
        super().__init__(name=f"dual{DIRECTIONS}")

    def can_convert_from(self, _context: Any, other_type: types.Type) -> Conversion | None:
        """Return how numba converts a type to this type; None if it is no type of numbers or bools.

        The derivatives of a converted number are 0.
        """
        return Conversion.promote if isinstance(other_type, types.Number | types.Boolean) else None

    def unify(self, _context: Any, other_type: types.Type) -> types.Type | None:
        """Return the type of a variable that has values of this type and of another type: this type.

        The result is None if the other type is no type of numbers or bools.
        """
        return self if isinstance(other_type, types.Number | types.Boolean) else None


DUAL = Dual()


@register_model(Dual)
class _Model(models.PrimitiveModel):
    """The layout of a dual number in memory and in registers: first the value, then the derivatives."""

    def __init__(self, manager: Any, kind: Dual) -> None:
        super().__init__(manager, kind, ir.LiteralStructType([ir.DoubleType(), VECTOR], packed=True))


# ---- code in LLVM's language ------------------------------------------------------------------------------


def _make_dual(builder: ir.IRBuilder, value: ir.Value, slopes: ir.Value) -> ir.Value:
    kind = ir.LiteralStructType([ir.DoubleType(), VECTOR], packed=True)
    dual = builder.insert_value(ir.Constant(kind, ir.Undefined), value, 0)
    return builder.insert_value(dual, slopes, 1)


def _value_and_slopes(builder: ir.IRBuilder, dual: ir.Value) -> tuple[ir.Value, ir.Value]:
    return builder.extract_value(dual, 0), builder.extract_value(dual, 1)


def _repeat_number(builder: ir.IRBuilder, number: ir.Value) -> ir.Value:
    """Return a vector of DIRECTIONS entries, each of which is ``number``."""
    vector = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), number, cgutils.int32_t(0))
    lane_indices = ir.Constant(ir.VectorType(cgutils.int32_t, DIRECTIONS), [0] * DIRECTIONS)
    return builder.shuffle_vector(vector, ir.Constant(VECTOR, ir.Undefined), lane_indices)


def _scale_slopes(builder: ir.IRBuilder, number: ir.Value, slopes: ir.Value) -> ir.Value:
    return builder.fmul(_repeat_number(builder, number), slopes)


def _zero_slopes() -> ir.Value:
    return ir.Constant(VECTOR, [0.0] * DIRECTIONS)


def _cast(
    context: Any, builder: ir.IRBuilder, given_type: types.Type, _to: types.Type, value: ir.Value
) -> Any:
    return _make_dual(builder, context.cast(builder, value, given_type, float64), _zero_slopes())


for _kind in (types.Float, types.Integer, types.Boolean, types.IntegerLiteral):
    lower_cast(_kind, Dual)(_cast)


# ---- types of the results of functions --------------------------------------------------------------------


def _declare(function: Any, result: types.Type, number: types.Type | None = float64) -> None:
    """Declare to numba that a function takes at least one dual number, and returns the type ``result``.

    The other arguments are ordinary numbers, which numba converts to the type ``number`` or, if this is None,
    does not convert.
    """

    class _Template(AbstractTemplate):
        key = function

        def generic(self, arguments: Sequence[types.Type], keywords: Any) -> Any:
            plain = (types.Number, types.Boolean)
            if keywords or not any(isinstance(argument, Dual) for argument in arguments):
                return None
            if not all(isinstance(argument, (Dual, *plain)) for argument in arguments):
                return None
            return signature(
                result,
                *(argument if isinstance(argument, Dual) else number or argument for argument in arguments),
            )

    infer_global(function)(_Template)


Code = Callable[..., ir.Value]


def _lower(function: Any, code: Code, *kinds: types.Type) -> None:
    """Give numba the code of ``function`` for arguments of the types ``kinds``.

    ``code(context, builder, *arguments)`` writes this code, and returns the LLVM value of the result.
    """

    def lower_call(context: Any, builder: ir.IRBuilder, _signature: Any, arguments: Any) -> ir.Value:
        return code(context, builder, *arguments)

    lower_builtin(function, *kinds)(lower_call)


def _ordinary_value(context: Any, builder: ir.IRBuilder, function: Any, *numbers: ir.Value) -> ir.Value:
    """Return the LLVM value of ``function`` for ordinary ``numbers``, by numba's own code."""
    call_signature = context.typing_context.resolve_function_type(function, (float64,) * len(numbers), {})
    return context.get_function(function, call_signature)(builder, numbers)


# ---- arithmetic -------------------------------------------------------------------------------------------

_AUGMENTED_OPERATORS = {
    operator.add: operator.iadd,
    operator.sub: operator.isub,
    operator.mul: operator.imul,
    operator.truediv: operator.itruediv,
}
_NUMBER_ONE = ir.Constant(ir.DoubleType(), 1.0)


def _bilinear_codes(operation: str, slopes: Callable[..., tuple[ir.Value, ir.Value]]) -> tuple[Code, ...]:
    """Return the codes of a sum, difference or product for the types ``_KINDS`` of its operands a and b.

    ``operation`` is the name of LLVM's instruction for the values. ``slopes(a, b)`` returns the derivatives
    of the result with respect to a and to b.
    """

    def code(_context: Any, builder: ir.IRBuilder, x: ir.Value, y: ir.Value) -> ir.Value:
        (a, *da), (b, *db) = (
            (number,) if number.type == ir.DoubleType() else _value_and_slopes(builder, number)
            for number in (x, y)
        )
        by_a, by_b = slopes(a, b)
        terms = [_scale_slopes(builder, by_a, slope) for slope in da]
        terms += [_scale_slopes(builder, by_b, slope) for slope in db]
        return _make_dual(builder, getattr(builder, operation)(a, b), functools.reduce(builder.fadd, terms))

    return code, code, code


def _quotient_codes() -> tuple[Code, ...]:
    def both(_context: Any, builder: ir.IRBuilder, x: ir.Value, y: ir.Value) -> ir.Value:
        (a, da), (b, db) = _value_and_slopes(builder, x), _value_and_slopes(builder, y)
        quotient = builder.fdiv(a, b)
        # derivative of a quotient: (a/b)′ = (a′ − (a/b) b′)/b
        slopes = builder.fsub(da, _scale_slopes(builder, quotient, db))
        return _make_dual(builder, quotient, _scale_slopes(builder, builder.fdiv(_NUMBER_ONE, b), slopes))

    def first(_context: Any, builder: ir.IRBuilder, x: ir.Value, b: ir.Value) -> ir.Value:
        a, da = _value_and_slopes(builder, x)
        return _make_dual(
            builder, builder.fdiv(a, b), _scale_slopes(builder, builder.fdiv(_NUMBER_ONE, b), da)
        )

    def second(_context: Any, builder: ir.IRBuilder, a: ir.Value, y: ir.Value) -> ir.Value:
        b, db = _value_and_slopes(builder, y)
        quotient = builder.fdiv(a, b)
        slope = builder.fneg(builder.fdiv(quotient, b))
        return _make_dual(builder, quotient, _scale_slopes(builder, slope, db))

    return both, first, second


_CODES = {
    operator.add: _bilinear_codes("fadd", lambda _a, _b: (_NUMBER_ONE, _NUMBER_ONE)),
    operator.sub: _bilinear_codes("fsub", lambda _a, _b: (_NUMBER_ONE, ir.Constant(ir.DoubleType(), -1.0))),
    operator.mul: _bilinear_codes("fmul", lambda a, b: (b, a)),
    operator.truediv: _quotient_codes(),
}
_KINDS = ((Dual, Dual), (Dual, types.Float), (types.Float, Dual))

for _function, _codes in _CODES.items():
    for _operation in (_function, _AUGMENTED_OPERATORS[_function]):
        _declare(_operation, DUAL)
        for _kinds, _code in zip(_KINDS, _codes, strict=True):
            _lower(_operation, _code, *_kinds)


# ---- comparisons, extremes and functions ------------------------------------------------------------------

for _function, _relation in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
    (operator.ne, "!="),
):
    _declare(_function, boolean)

    def _compare(
        _context: Any, builder: ir.IRBuilder, x: ir.Value, y: ir.Value, relation: str = _relation
    ) -> ir.Value:
        a, b = (
            builder.extract_value(operand, 0) if operand.type != ir.DoubleType() else operand
            for operand in (x, y)
        )
        compare = builder.fcmp_unordered if relation == "!=" else builder.fcmp_ordered
        return compare(relation, a, b)

    for _kinds in _KINDS:
        _lower(_function, _compare, *_kinds)


def _extreme_code(relation: str) -> Any:
    def lower_call(_context: Any, builder: ir.IRBuilder, _signature: Any, arguments: Any) -> ir.Value:
        best, *other_numbers = arguments
        for candidate in other_numbers:
            # max and min return the first of equal numbers, as in Python
            a, b = (builder.extract_value(number, 0) for number in (candidate, best))
            best = builder.select(builder.fcmp_ordered(relation, a, b), candidate, best)
        return best

    return lower_call


for _function, _relation in ((max, ">"), (min, "<")):
    _declare(_function, DUAL, DUAL)
    lower_builtin(_function, types.VarArg(Dual))(_extreme_code(_relation))


def _lower_chain_rule(function: Any, slope: Code) -> None:
    """Give numba the code of a function f for a dual number with value a and derivatives a′.

    The result has the value f(a) and the derivatives f′(a) a′. ``slope(context, builder, a, f(a))`` writes
    the code of f′(a).
    """

    def code(context: Any, builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
        a, da = _value_and_slopes(builder, x)
        value = _ordinary_value(context, builder, function, a)
        return _make_dual(builder, value, _scale_slopes(builder, slope(context, builder, a, value), da))

    _declare(function, DUAL)
    _lower(function, code, Dual)


def _root_slope(_context: Any, builder: ir.IRBuilder, _a: ir.Value, root: ir.Value) -> ir.Value:
    """Return the derivative ½/√a of a root √a; 0 where √a is not above 0, such as at a = 0.

    The kernel takes the root of a clearance that stays 0. The derivatives of this clearance are 0; times the
    factor ½/√a, which is infinite, they would give NaN as derivatives of the root.
    """
    slope = builder.fdiv(ir.Constant(root.type, 0.5), root)
    zero = ir.Constant(root.type, 0.0)
    return builder.select(builder.fcmp_ordered(">", root, zero), slope, zero)


def _sign_of(_context: Any, builder: ir.IRBuilder, a: ir.Value, _value: ir.Value) -> ir.Value:
    plus_one, zero = ir.Constant(a.type, 1.0), ir.Constant(a.type, 0.0)
    return builder.select(builder.fcmp_ordered("<", a, zero), ir.Constant(a.type, -1.0), plus_one)


_lower_chain_rule(math.sqrt, _root_slope)
_lower_chain_rule(abs, _sign_of)


def _negate(_context: Any, builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
    a, da = _value_and_slopes(builder, x)
    return _make_dual(builder, builder.fneg(a), builder.fneg(da))


_declare(operator.neg, DUAL)
_lower(operator.neg, _negate, Dual)


def _is_finite(context: Any, builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
    return _ordinary_value(context, builder, math.isfinite, builder.extract_value(x, 0))


_declare(math.isfinite, boolean)
_lower(math.isfinite, _is_finite, Dual)


def _hypot(context: Any, builder: ir.IRBuilder, x: ir.Value, y: ir.Value) -> ir.Value:
    (a, da), (b, db) = _value_and_slopes(builder, x), _value_and_slopes(builder, y)
    length = _ordinary_value(context, builder, math.hypot, a, b)
    # derivative of √(a² + b²): (a a′ + b b′)/√(a² + b²)
    slopes = builder.fadd(_scale_slopes(builder, a, da), _scale_slopes(builder, b, db))
    zero = ir.Constant(length.type, 0.0)
    inverse = builder.fdiv(_NUMBER_ONE, length)
    # at length 0 the derivatives are set to 0, as for the square root (``_root_slope``)
    inverse = builder.select(builder.fcmp_ordered(">", length, zero), inverse, zero)
    return _make_dual(builder, length, _scale_slopes(builder, inverse, slopes))


_declare(math.hypot, DUAL)
_lower(math.hypot, _hypot, Dual, Dual)


def _is_nonzero(_context: Any, builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
    a = builder.extract_value(x, 0)
    return builder.fcmp_unordered("!=", a, ir.Constant(a.type, 0.0))


_declare(bool, boolean)
_lower(bool, _is_nonzero, Dual)


# ---- functions of kernel/tangent/duals.py, which read and make dual numbers -------------------------------


def _attach_slope(
    _context: Any, builder: ir.IRBuilder, number: ir.Value, slope: ir.Value, argument: ir.Value
) -> ir.Value:
    return _make_dual(builder, number, _scale_slopes(builder, slope, builder.extract_value(argument, 1)))


def _read_slope(_context: Any, builder: ir.IRBuilder, x: ir.Value, direction: ir.Value) -> ir.Value:
    return builder.extract_element(builder.extract_value(x, 1), direction)


def _has_slope(_context: Any, builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
    slopes = builder.extract_value(x, 1)
    is_any_nonzero: ir.Value = ir.Constant(ir.IntType(1), 0)
    for direction in range(DIRECTIONS):
        derivative = builder.extract_element(slopes, cgutils.int32_t(direction))
        is_any_nonzero = builder.or_(
            is_any_nonzero, builder.fcmp_unordered("!=", derivative, ir.Constant(derivative.type, 0.0))
        )
    return is_any_nonzero


_declare(duals.value, float64)
_lower(duals.value, lambda _context, builder, x: builder.extract_value(x, 0), Dual)
_declare(duals.dual_with_slope, DUAL)
_lower(duals.dual_with_slope, _attach_slope, types.Float, types.Float, Dual)
_declare(duals.slope, float64, types.int64)
_lower(duals.slope, _read_slope, Dual, types.Integer)
_declare(duals.replace_slope, DUAL, None)
_lower(
    duals.replace_slope,
    lambda _c, b, x, k, number: _make_dual(
        b, _value_and_slopes(b, x)[0], b.insert_element(_value_and_slopes(b, x)[1], number, k)
    ),
    *(Dual, types.Integer, types.Float),
)
_declare(duals.has_slope, boolean)
_lower(duals.has_slope, _has_slope, Dual)
