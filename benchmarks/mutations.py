"""Small faults that are put into the source of a module, one at a time, for mutants.py."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

Change = Callable[[ast.AST], ast.AST | None]
"""Makes the faulty node of a copy of the right one; None removes a statement."""

COMPARISONS: dict[type, type] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
}
BOUNDS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
ARITHMETIC: dict[type, type] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
}
SWAPPED = {"min": "max", "max": "min"}
TABLE = 8  # a literal with more numbers is a table of data, which is left out
AROUND = 40  # characters that are shown before and after a fault
KINDS = {
    "bound": "< to <=, > to >=, and back",
    "comparison": "== to !=, and back",
    "arithmetic": "+ to -, * to /, ** to *, and back",
    "sign": "-x to x",
    "number": "0 to 1, n to n + 1, c to 1.1 c, True to False",
    "logic": "and to or, and back",
    "condition": "a condition negated",
    "extreme": "min to max, and back",
    "statement": "a call, or an assignment to an element or to a field, removed",
    "answer": "0 returned",
}


@dataclass(frozen=True)
class Mutant:
    """A fault.

    Attributes:
        file: of the source.
        place: the number of the node in the walk over the tree.
        kind: of KINDS.
        line: where it is.
        owner: the function at the top of the module, or the name, that the fault is in.
        text: the right source, and the faulty one.
        change: makes the fault.
    """

    file: Path
    place: int
    kind: str
    line: int
    owner: str
    text: str
    change: Change

    def tree(self) -> ast.Module:
        """The module with the fault."""
        return _changed(ast.parse(self.file.read_text(encoding="utf-8")), self.place, self.change)


def mutants_of(file: Path) -> list[Mutant]:
    """All faults that a module can be given."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    left_out, owners = _left_out(tree), _owners(tree)
    statements = _statements(tree)
    found = []
    for place, node in enumerate(ast.walk(tree)):
        if id(node) in left_out:
            continue
        for kind, change in _faults(node):
            before = statements[id(node)]
            text = _near(_head(before), _difference(before, node, change))
            line = getattr(node, "lineno", before.lineno)
            found.append(Mutant(file, place, kind, line, owners[id(node)], text, change))
    return found


def _faults(node: ast.AST) -> Iterator[tuple[str, Change]]:
    """The faults of one node."""
    match node:
        case ast.Compare(ops=[op]) if type(op) in COMPARISONS:
            kind = "bound" if isinstance(op, BOUNDS) else "comparison"
            yield kind, lambda one: _with(one, ops=[COMPARISONS[type(one.ops[0])]()])  # type: ignore[attr-defined]
        case ast.BinOp(op=op) | ast.AugAssign(op=op) if type(op) in ARITHMETIC and not _is_text(node):
            yield "arithmetic", lambda one: _with(one, op=ARITHMETIC[type(one.op)]())  # type: ignore[attr-defined]
        case ast.UnaryOp(op=ast.USub()):
            yield "sign", lambda one: one.operand  # type: ignore[attr-defined]
        case ast.UnaryOp(op=ast.Not()):
            yield "condition", lambda one: one.operand  # type: ignore[attr-defined]
        case ast.Constant(value=bool() | int() | float()):
            yield "number", lambda one: ast.Constant(_other(one.value))  # type: ignore[attr-defined]
        case ast.BoolOp():
            yield "logic", lambda one: _with(one, op=ast.Or() if isinstance(one.op, ast.And) else ast.And())  # type: ignore[attr-defined]
        case ast.Call(func=ast.Name(id="min" | "max")):
            yield "extreme", lambda one: _with(one, func=ast.Name(SWAPPED[one.func.id], ast.Load()))  # type: ignore[attr-defined]
        case ast.Return(value=value) if value is not None and not isinstance(value, ast.Constant):
            yield "answer", lambda one: _with(one, value=ast.Constant(0))
    match node:
        case ast.If(test=test) | ast.While(test=test) | ast.IfExp(test=test):
            if not isinstance(test, ast.UnaryOp):
                yield "condition", lambda one: _with(one, test=ast.UnaryOp(ast.Not(), one.test))  # type: ignore[attr-defined]
        case ast.Expr(value=ast.Call()) | ast.AugAssign():
            yield "statement", lambda _: None
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript(), *_]):
            yield "statement", lambda _: None


def _with(node: ast.AST, **fields: object) -> ast.AST:
    for name, value in fields.items():
        setattr(node, name, value)
    return node


def _other(value: float) -> float:
    """Another number."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    return 1.1 * value if value else 1.0


def _is_text(node: ast.AST) -> bool:
    return any(isinstance(one, ast.JoinedStr) or _is_string(one) for one in ast.walk(node))


def _is_string(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _left_out(tree: ast.Module) -> set[int]:
    """Annotations, and tables of numbers."""
    nodes: list[ast.AST] = []
    for node in ast.walk(tree):
        nodes += [one for name in ("annotation", "returns") if (one := getattr(node, name, None))]
        if isinstance(node, ast.Dict | ast.Tuple | ast.List) and _numbers(node) > TABLE:
            nodes.append(node)
    return {id(one) for node in nodes for one in ast.walk(node)}


def _numbers(node: ast.AST) -> int:
    return sum(isinstance(one, ast.Constant) and isinstance(one.value, float) for one in ast.walk(node))


def _owners(tree: ast.Module) -> dict[int, str]:
    """The function or class at the top that each node is in, or the name it gives a value to."""
    owners = {}
    for statement in tree.body:
        match statement:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                pass
            case (
                ast.Assign(targets=[target, *_]) | ast.AnnAssign(target=target) | ast.AugAssign(target=target)
            ):
                name = ast.unparse(target)
            case _:
                name = ""
        owners |= {id(node): name for node in ast.walk(statement)}
        for decorator in getattr(statement, "decorator_list", []):
            owners |= {id(node): f"@{name}" for node in ast.walk(decorator)}
    return owners


def _statements(tree: ast.Module) -> dict[int, ast.stmt]:
    """The innermost statement that each node is in."""
    inner: dict[int, ast.stmt] = {}
    for statement in (node for node in ast.walk(tree) if isinstance(node, ast.stmt)):
        inner |= {id(node): statement for node in ast.walk(statement)}
    return inner


def _near(right: str, faulty: str) -> str:
    """Two lines, as far as they differ, with some of what is around."""
    same = next((k for k, (one, other) in enumerate(zip(right, faulty, strict=False)) if one != other), 0)
    back = next(
        (k for k, (one, other) in enumerate(zip(right[::-1], faulty[::-1], strict=False)) if one != other), 0
    )
    back = min(back, min(len(right), len(faulty)) - same)
    start, more = max(0, same - AROUND), max(0, back - AROUND)
    return " -> ".join(line[start : len(line) - more] for line in (right, faulty))


def _head(statement: ast.stmt) -> str:
    """The first line of a statement."""
    return ast.unparse(statement).partition("\n")[0]


def _difference(statement: ast.stmt, node: ast.AST, change: Change) -> str:
    """The first line of a statement whose node is changed."""
    place = next(k for k, one in enumerate(ast.walk(statement)) if one is node)
    holder = ast.Module([copy.deepcopy(statement)], [])
    return _head(_changed(holder, place + 1, change).body[0])


def _changed(tree: ast.Module, place: int, change: Change) -> ast.Module:
    """A tree whose node of that number is changed."""
    target = next(node for k, node in enumerate(ast.walk(tree)) if k == place)

    class Changer(ast.NodeTransformer):
        def visit(self, node: ast.AST) -> ast.AST | None:
            if node is not target:
                return self.generic_visit(node)
            changed = change(node)
            return ast.Pass() if changed is None else changed

    return ast.fix_missing_locations(Changer().visit(tree))
