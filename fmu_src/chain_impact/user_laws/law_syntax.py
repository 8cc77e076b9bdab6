"""The check of a law's file: only listed forms of syntax are allowed, so that a file cannot run other code.

Python evaluates the constants of a file and the default values of arguments. numba compiles the functions;
Python does not run them. A law can use only the names of ``FUNCTIONS``, of ``MATH`` and of its own file.
"""

from __future__ import annotations

import ast
import builtins
import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any

FUNCTIONS: dict[str, Callable[..., Any]] = {
    function.__name__: function for function in (abs, bool, float, int, max, min, pow, range, round)
}
"""Name → function: the built-in functions of Python that a law can call."""
LONG = {"comb", "dist", "factorial", "fsum", "isqrt", "lcm", "perm", "prod", "sumprod"}
"""Functions of ``math`` that a law cannot use: kernels do not have these functions, and the evaluation of a
constant with such a function could take long."""
MATH = {name for name in dir(math) if name[0] != "_"} - LONG
"""The names of ``math``, functions and constants, that a law can use."""
ALLOWED_SYNTAX = (
    "a law's file can have: import math, constants, and functions with arithmetic, comparisons, if, for, "
    f"while, the functions of math, {', '.join(FUNCTIONS)} and those of the file"
)

EXPRESSIONS = (
    *(ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Call, ast.keyword),
    *(ast.Constant, ast.Name, ast.Attribute, ast.Tuple, ast.Subscript, ast.Yield),
    *(ast.Load, ast.Store),
    *(ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow, ast.UAdd, ast.USub),
    *(ast.And, ast.Or, ast.Not, ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE),
)
TOP = (ast.FunctionDef, ast.Import, ast.ImportFrom, ast.Assign, ast.AnnAssign)
STATEMENTS = (
    *(ast.AugAssign, ast.If, ast.For, ast.While, ast.Break, ast.Continue, ast.Pass, ast.Return, ast.Expr),
    *(ast.arguments, ast.arg, ast.alias),
)
NODES = {ast.Module, *TOP, *STATEMENTS, *EXPRESSIONS}
ANNOTATIONS = {"bool", "float", "int"}
LONGEST_QUOTE = 40  # largest number of characters of a refused text that an error shows
WORDS = {"inf", "-inf", "+inf", "nan", "infinity", "-infinity"}
"""The words, in small or capital letters, that ``float("…")`` can have; other texts must be statements."""


class LawError(ValueError):
    """Raised for a file or a function that is not a usable law.

    The message is the end of a sentence whose subject, the law, the caller puts in front.
    """


def check_syntax(tree: ast.Module, source: str) -> None:
    """Refuse a file that contains anything but a law, before any part of the file is evaluated.

    ``tree`` is the syntax tree of the text ``source``.

    Raises:
        LawError: with the line, and the allowed syntax.
    """
    for node in ast.walk(tree):
        _check_common(node)
    refused = next(_refused(tree), None)
    if refused is not None:
        segment_text = " ".join((ast.get_source_segment(source, refused) or type(refused).__name__).split())
        shown_text = segment_text.encode("ascii", "backslashreplace").decode()
        if len(shown_text) > LONGEST_QUOTE:
            shown_text = f"{shown_text[: LONGEST_QUOTE - 3]}..."
        raise LawError(f"has {shown_text} in line {_line(refused)}; {ALLOWED_SYNTAX}")


def _check_common(node: ast.AST) -> None:
    """Raise a LawError with a special message if a node of the syntax tree is a frequent mistake."""
    imported = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
    imported += ["." * node.level + (node.module or "")] if isinstance(node, ast.ImportFrom) else []
    for module in imported:
        if module != math.__name__:
            raise LawError(f"imports {module} in line {_line(node)}; a law can import math only")
    if isinstance(node, ast.Raise | ast.Assert):
        raise LawError(f"raises in line {_line(node)}; a law has to return a force")
    if isinstance(node, ast.List | ast.ListComp | ast.Dict | ast.Set):
        raise LawError(f"makes arrays or lists in line {_line(node)}; a law can use numbers only")


def _line(node: Any) -> int:
    return int(node.lineno)


def _refused(tree: ast.Module) -> Iterator[ast.AST]:
    """Yield, for each part of a file's syntax tree that is not allowed, the node that an error shows."""
    names = _Names(tree)
    for node in ast.walk(tree):
        for child in ast.iter_child_nodes(node):
            if type(child) not in NODES:
                yield child if hasattr(child, "lineno") else node
        if not names.allow(node):
            yield next(iter(getattr(node, "decorator_list", ())), node)
    for statement in tree.body:
        if isinstance(statement, ast.Assign | ast.AnnAssign):
            yield from names.not_constant(statement.value)
        elif not isinstance(statement, TOP) and not _is_text(statement):
            yield statement
    for node in ast.walk(tree):
        if isinstance(node, ast.arguments):
            for default in filter(None, (*node.defaults, *node.kw_defaults)):
                yield from names.not_constant(default, calls=False)


def _is_text(statement: ast.AST) -> bool:
    """Return whether a statement consists of a text only, such as a docstring."""
    value = statement.value if isinstance(statement, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


class _Names:
    """The names that a file defines, and the rules for syntax that depend on them."""

    def __init__(self, tree: ast.Module) -> None:
        self._all = set(_bound(ast.walk(tree)))
        heads = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
        constants = [node for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign)]
        imports = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
        defined = {*_bound(heads), *_bound(part for node in constants for part in ast.walk(node))}
        imported = set(_bound(part for node in imports for part in ast.walk(node)))
        self._top = defined | imported
        self._callable = (imported | set(FUNCTIONS)) - defined
        self._math = {
            alias.asname or alias.name
            for node in ast.walk(tree)
            if isinstance(node, ast.Import)
            for alias in node.names
        }
        self._texts = {id(text) for node in ast.walk(tree) for text in _texts(node)}

    def allow(self, node: ast.AST) -> bool:
        """Return whether a node, whose type is in NODES, keeps the other rules, without its children."""
        is_allowed = True
        match node:
            case ast.Name(id=name):
                is_name = name in self._all or name in FUNCTIONS or not hasattr(builtins, name)
                is_allowed = is_name and not name.startswith("__")
            case ast.Attribute(value=ast.Name(id=name), attr=attribute, ctx=ast.Load()):
                is_allowed = name in self._math and attribute in MATH
            case ast.Attribute():
                is_allowed = False
            case ast.Subscript(ctx=context):
                is_allowed = isinstance(context, ast.Load)
            case ast.Constant(value=value):
                is_allowed = id(node) in self._texts or value is None or isinstance(value, bool | int | float)
            case ast.FunctionDef(name=name, decorator_list=decorators, returns=kind):
                is_plain = not decorators and not getattr(node, "type_params", None)
                is_allowed = is_plain and not name.startswith("__") and _is_annotation(kind)
            case ast.arg(arg=name, annotation=kind):
                is_allowed = not name.startswith("__") and _is_annotation(kind)
            case ast.AnnAssign(annotation=kind):
                is_allowed = _is_annotation(kind)
            case ast.keyword(arg=keyword):
                is_allowed = keyword is not None
            case ast.ImportFrom(names=aliases):
                is_allowed = all(alias.name in MATH for alias in aliases)
            case ast.alias(asname=name):
                is_allowed = not (name or "").startswith("__")
        return is_allowed

    def not_constant(self, value: ast.AST | None, *, calls: bool = True) -> Iterator[ast.AST]:
        """Yield the parts of an expression that a constant must not have.

        Args:
            value: the expression, or None for a missing one.
            calls: whether the expression may call functions of ``math`` and of Python.
        """
        for node in ast.walk(value) if value else ():
            match node:
                case ast.Name(id=name) if name not in self._top and hasattr(builtins, name):
                    if name not in FUNCTIONS:
                        yield node
                case ast.Call(func=ast.Name(id=name)):
                    if not calls or name not in self._callable:
                        yield node
                case ast.Call(func=function):
                    if not calls or not isinstance(function, ast.Attribute):
                        yield node
                case ast.Yield():
                    yield node


def _bound(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Yield the names that some nodes define: of variables, arguments, functions and imports."""
    for node in nodes:
        match node:
            case ast.Name(id=name, ctx=ast.Store()) | ast.arg(arg=name) | ast.FunctionDef(name=name):
                yield name
            case ast.alias(name=name, asname=other):
                yield other or name


def _texts(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the text that is a direct child of a node, if a text is allowed there.

    Allowed are a statement that consists of a text, such as a docstring, and a word of WORDS in
    ``float("…")``.
    """
    match node:
        case ast.Expr(value=text) if _is_text(node):
            yield text
        case ast.Call(func=ast.Name(id="float"), args=[ast.Constant(value=str(word)) as text]):
            if word.strip().lower() in WORDS:
                yield text


def _is_annotation(kind: ast.AST | None) -> bool:
    """Return whether an annotation is missing (None), or is the name of a type of numbers."""
    return kind is None or (isinstance(kind, ast.Name) and kind.id in ANNOTATIONS)
