"""The language of rules: conditions and numbers as text, which Python and the pages evaluate alike.

A rule is written like an expression of Python. From strong to weak, its parts are

- numbers, texts in quotes, and names of values, such as ``chain.base``
- ``has_value(name)``, true if the value is not missing; ``any(list, rule)``, true if the rule is true for at
  least one member of the list; ``sum(list, rule)``, the sum of the rule's numbers for all members
- ``a*b``, then ``a + b``; a condition counts as 0 or 1
- ``==``, ``!=``, ``<``, ``>``, ``<=``, ``>=``, ``in``
- ``not``, then ``and``, then ``or``

In the rule that is an argument of ``any`` or ``sum``, ``order`` is the index of the member in the list, from
0. If the list is in the scene's file, as ``chain.links``, any other name without a dot is a key of the
member. For any other list, a name is a value of the member if the member has this value, else a value of the
scene. The list may also be tables by name, as ``contact.wall``; the members are then these tables.

A value counts as true if it is neither missing nor 0 nor empty; a list, if one of its entries counts as true.
Where a number is needed, a list counts as its length. A sum or a product with a missing value is missing. A
comparison with a missing value is false.

``tree`` parses a rule; ``_function_of`` evaluates the tree.
The twin in JavaScript is pages/browser/scene/rules.js.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from typing import Any, TypeAlias

Tree: TypeAlias = dict[str, Any]
"""A part of a rule: ``{"constant": 2}``, ``{"name": "chain.base"}``, or ``{"operator": "<", "parts":
[...]}``, an operator or function with its operands, each of which is a tree."""
ValueOf: TypeAlias = Callable[[str], Any]
"""A function that returns the value of a name in a rule, or None if the value is missing."""
_SIGNS: dict[type, str] = {
    ast.And: "and",
    ast.Or: "or",
    ast.Not: "not",
    ast.Add: "+",
    ast.Mult: "*",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Lt: "<",
    ast.Gt: ">",
    ast.LtE: "<=",
    ast.GtE: ">=",
    ast.In: "in",
}
"""Operator of Python's syntax → its sign in a rule; a rule has no other operators."""
_FUNCTIONS = {"has_value": 1, "any": 2, "sum": 2}
"""Name of a function in rules → its number of arguments."""
_BOOLEAN_OPERATORS: dict[str, Callable[[Iterable[bool]], bool]] = {"and": all, "or": any}
_UNARY_OPERATORS: dict[str, Callable[[Any], bool]] = {
    "not": lambda value: not _is_true(value),
    "has_value": lambda value: value is not None,
}
_BINARY_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "*": operator.mul,
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
    "in": lambda value, entries: value in entries,
}
"""``_BOOLEAN_OPERATORS``, ``_UNARY_OPERATORS``, ``_BINARY_OPERATORS``: sign of an operator → function that
computes the operator from the values of any number of operands, of one, or of two. A function of two operands
never gets a missing value."""


@cache
def tree(rule: str) -> Tree:
    """Return the tree of a rule; all callers get the same object, which nothing may change.

    Raises:
        ValueError: when ``rule`` is not a rule; the message has its text.
    """
    try:
        return _tree(ast.parse(rule, mode="eval").body)
    except (SyntaxError, ValueError) as error:
        raise ValueError(f"the rule {rule!r} is wrong: {error}") from None


def _tree(node: ast.AST) -> Tree:
    match node:
        case ast.Constant(value=int() | float() | str() as constant):
            return {"constant": constant}
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as constant)):
            return {"constant": -constant}
        case ast.Name(id=name):
            return {"name": name}
        case ast.Attribute(value=table, attr=key) if "name" in (table_tree := _tree(table)):
            return {"name": f"{table_tree['name']}.{key}"}
    sign, parts = _operation(node)
    if not sign:
        raise ValueError(f"there is no {ast.unparse(node)}")
    return {"operator": sign, "parts": [_tree(part) for part in parts]}


def _operation(node: ast.AST) -> tuple[str | None, Sequence[ast.AST]]:
    """Return the sign and the operands of an operation, or the name and the arguments of a function.

    The sign or name is None for an operation or a function that rules do not have.
    """
    match node:
        case ast.BoolOp(op=of, values=parts):
            return _SIGNS.get(type(of)), parts
        case ast.BinOp(op=of, left=left, right=right):
            return _SIGNS.get(type(of)), (left, right)
        case ast.UnaryOp(op=of, operand=part):
            return _SIGNS.get(type(of)), (part,)
        case ast.Compare(left=left, ops=[of], comparators=[right]):
            return _SIGNS.get(type(of)), (left, right)
        case ast.Call(func=ast.Name(id=name), args=parts, keywords=[]):
            return (name if _FUNCTIONS.get(name) == len(parts) else None), parts
    return None, ()


def names_in(part: Tree) -> Iterator[str]:
    """Yield the names in a tree, except ``order`` in the arguments of ``any`` and ``sum``."""
    if "name" in part:
        yield part["name"]
    has_members = part.get("operator") in ("any", "sum")
    for inner_part in part.get("parts", ()):
        yield from (name for name in names_in(inner_part) if not (has_members and name == "order"))


def is_rule_true(rule: str, value_of: ValueOf) -> bool:
    """Return whether a rule is true; ``value_of`` is a function from a name in the rule to its value.

    A rule whose value is missing is not true.
    """
    return _is_true(_function(rule)(value_of))


def number_in(rule: str, value_of: ValueOf) -> Any:
    """Return the value of a rule, a number or a text; None if the value is missing.

    A condition gives the number 0 or 1, a list the number of its entries. The rule must not name tables by
    name, such as ``contact.wall``.
    """
    value = _length_or_value(_function(rule)(value_of))
    return int(value) if value is True or value is False else value


def numbers_of(rule: str, members: Iterable[Any], value_of: ValueOf) -> list[Any]:
    """Return the value of a rule, a number or a text, for each of ``members``; None where it is missing.

    ``value_of`` gives the values that the members do not have (``value_within``).
    """
    number = partial(number_in, rule)
    return _member_values(number, tuple(names_in(tree(rule))), members, value_of)


def members_in(rule: str, value_of: ValueOf) -> Collection[Any]:
    """Return the members of the list that a rule names.

    If the rule gives a whole number n, the result has n members without values. If the value of the rule is
    missing, there are no members.
    """
    value = _function(rule)(value_of)
    return [{}] * value if isinstance(value, int) else _members(value)


@cache
def _function(rule: str) -> Callable[[ValueOf], Any]:
    return _function_of(tree(rule))


def _function_of(part: Tree) -> Callable[[ValueOf], Any]:
    """Return the function that computes a part of a rule.

    With a missing value, a name, a product or a sum gives None, and a comparison gives False.
    """
    if "parts" not in part:
        name, constant = part.get("name"), part.get("constant")
        return (lambda value_of: value_of(name)) if name else (lambda _: constant)
    sign, operands = part["operator"], [_function_of(inner_part) for inner_part in part["parts"]]
    if sign in ("any", "sum"):
        return partial(_member_function, sign, operands[0], operands[1], tuple(names_in(part["parts"][1])))
    if sign in _BOOLEAN_OPERATORS:
        of_all = _BOOLEAN_OPERATORS[sign]
        return lambda value_of: of_all(_is_true(operand_function(value_of)) for operand_function in operands)
    if sign in _UNARY_OPERATORS:
        of_one, single_operand = _UNARY_OPERATORS[sign], operands[0]
        return lambda value_of: of_one(single_operand(value_of))
    return partial(_binary_function, sign, operands[0], operands[1])


def _member_function(
    sign: str,
    members: Callable[[ValueOf], Any],
    rule: Callable[[ValueOf], Any],
    names: Sequence[str],
    value_of: ValueOf,
) -> Any:
    """Return the value of ``any(list, rule)`` or ``sum(list, rule)``; ``sign`` is "any" or "sum".

    The value of ``any`` is whether the rule is true for at least one member. The value of ``sum`` is the sum
    of the rule's numbers for all members, or None if one of these numbers is missing.

    Args:
        sign: the name of the function.
        members: function that returns the list.
        rule: function that computes the rule.
        names: the names in the rule.
        value_of: the values of names for the whole scene.
    """
    values = _member_values(rule, names, _members(members(value_of)), value_of)
    if sign == "any":
        return any(map(_is_true, values))
    return None if None in values else sum(values)


def _member_values(
    rule: Callable[[ValueOf], Any], names: Sequence[str], members: Iterable[Any], value_of: ValueOf
) -> list[Any]:
    """Return for each member the value of a part of a rule, which the function ``rule`` computes.

    The part is evaluated once for all members that have equal values of ``names``, the names in the part.
    """
    values_by_index, values = dict[tuple[Any, ...], Any](), []
    for order, member in enumerate(members):
        member_value = member.get if isinstance(member, dict) else partial(getattr, member)
        key = tuple([order if name == "order" else member_value(name, None) for name in names])
        if key not in values_by_index:
            values_by_index[key] = rule(partial(value_within, member, order, value_of))
        values.append(values_by_index[key])
    return values


def _binary_function(
    sign: str,
    left_function: Callable[[ValueOf], Any],
    right_function: Callable[[ValueOf], Any],
    value_of: ValueOf,
) -> Any:
    first_value, second_value = left_function(value_of), right_function(value_of)
    if first_value is None or second_value is None:
        return None if sign in ("+", "*") else False
    if sign != "in":
        first_value, second_value = _length_or_value(first_value), _length_or_value(second_value)
    return _BINARY_OPERATORS[sign](first_value, second_value)


def member_lookups(members: Iterable[Any], value_of: ValueOf) -> list[ValueOf]:
    """Return, for each member of a list, the function that gives the values of names in a rule (ValueOf).

    ``value_of`` gives the values that the member does not have (``value_within``).
    """
    return [partial(value_within, member, order, value_of) for order, member in enumerate(members)]


def value_within(member: Any, order: int, value_of: ValueOf, name: str) -> Any:
    """Return the value of a name in a rule for a member of a list; ``order`` is the index of the member.

    ``value_of`` gives the values of the whole scene: for a member that is a dict, of each name that is not in
    the dict; for a member that is a table of the scene's file, of each name with a dot.
    """
    if name == "order":
        return order
    if isinstance(member, dict):
        return member[name] if name in member else value_of(name)
    return value_of(name) if "." in name else getattr(member, name)


def _members(value: Any) -> Collection[Any]:
    return value.values() if isinstance(value, Mapping) else value or ()


def _length_or_value(value: Any) -> Any:
    return len(value) if type(value) in (tuple, list) else value


def _is_true(value: Any) -> bool:
    return any(map(_is_true, value)) if type(value) in (tuple, list) else bool(value)


def value_of_key(table: Any, key: str) -> Any:
    """Return the value of a dotted key in a table; None if this value, or a table on the path, is None."""
    for name in key.split("."):
        table = None if table is None else getattr(table, name)
    return table
