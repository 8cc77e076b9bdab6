"""A user's own contact law: a Python file that defines a function with the file's name.

The validation of a scene only reads the file (law_syntax.py); the build of a kernel compiles the law
(compilation/law.py), and links it to the kernel.
"""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from inspect import getsource
from pathlib import Path

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.forces.user_law import LAW_ARGUMENTS
from chain_impact.user_laws.law_syntax import LawError, check_syntax

__all__ = ["LawError", "UserLaw", "parse_law", "read_law", "source_of"]


@dataclass(frozen=True)
class UserLaw:
    """A user's contact law, as its file defines it.

    Attributes:
        id: the name of the law, which is also that of the file and of the function in the file.
        source: the text of the file.
        summary: the first line of the function's docstring, or "a user's law" if there is none.
        arguments: the names of the function's arguments, each one of ``LAW_ARGUMENTS``.
    """

    id: str
    source: str
    summary: str
    arguments: tuple[str, ...]


def read_law(path: Path) -> UserLaw:
    """Return the law of a file; the file is only read and checked, not run.

    Raises:
        LawError: when the file does not contain a valid law.
    """
    try:
        source = path.read_text(encoding="utf-8")
    except OSError as error:
        raise LawError(f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise LawError("cannot be read (it is not a text in UTF-8)") from None
    return parse_law(path.stem, source)


def parse_law(name: str, source: str) -> UserLaw:
    """Return the law ``name`` from the text of its file.

    Raises:
        LawError: when the text does not define a valid law in a function ``name``.
    """
    if not (name.isidentifier() and name.isascii()):
        raise LawError("must have the name of its law: letters, digits and _, not beginning with a digit")
    if name in (*CONTACT_LAWS, *LAW_ARGUMENTS):
        kind = "a contact law" if name in CONTACT_LAWS else "an argument of laws"
        raise LawError(f"must have the name of its law, and this must not be {name}, which is {kind} already")
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise LawError(f"is not valid Python: {str(error) or 'it is nested too deeply'}") from None
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    if name not in functions:
        raise LawError(f"must define the function {name}")
    check_syntax(tree, source)
    summary = (ast.get_docstring(functions[name]) or "a user's law").split("\n")[0]
    arguments = _arguments(functions[name])
    return UserLaw(name, source, re.sub(r"[^ -~\u00a0-\ud7ff]", " ", summary), arguments)


def _arguments(function: ast.FunctionDef) -> tuple[str, ...]:
    parameters = function.args
    names = tuple(argument.arg for argument in (*parameters.posonlyargs, *parameters.args))
    other_parameters = (parameters.vararg, *parameters.kwonlyargs, parameters.kwarg)
    other_names = [argument.arg for argument in other_parameters if argument]
    for name in (*names, *other_names):
        if name not in LAW_ARGUMENTS or name in other_names:
            raise LawError(f"{function.name} takes {name}; it can take {', '.join(LAW_ARGUMENTS)}")
    return names


def source_of(function: Callable[..., float]) -> str:
    """Return the text of a law's file for a Python function: ``import math``, then its source.

    A file with this text and the function's name defines the same law, if the only name from outside that the
    function uses is ``math``.

    Raises:
        LawError: when the function has no name, or Python does not know its source.
    """
    if not getattr(function, "__name__", "<").isidentifier():
        raise LawError("has no name: give a named function, written with def")
    try:
        return f"import math\n\n\n{textwrap.dedent(getsource(function))}"
    except (OSError, TypeError) as error:
        raise LawError(f"has no source that can be read ({error})") from None
