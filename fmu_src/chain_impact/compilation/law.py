"""A user's own contact law as a C function, to be linked to a kernel."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

from numba import float64, types
from numba.core.errors import NumbaError

from chain_impact.compilation.functions import LAW_FORCE, MODULES, compiled
from chain_impact.compilation.law_file import LawError, UserLaw
from chain_impact.compilation.law_syntax import FUNCTIONS
from chain_impact.kernel.forces.user_law import ARGUMENTS

MEMORY = "NRT required"  # the message of numba for a function that allocates memory


def law_entry(law: UserLaw) -> dict[str, tuple[Any, Callable[..., Any]]]:
    """Return the C function of a law, as an entry of entry_points.py.

    Raises:
        LawError: when the law cannot be compiled.
    """
    numbers = (float64,) * len(ARGUMENTS)
    return {LAW_FORCE: (float64(*numbers), _checked_function(law))}


def _checked_function(law: UserLaw) -> Callable[..., float]:
    """Return the Python function of a law that takes all of ``ARGUMENTS`` and can be compiled.

    Python evaluates the constants of the file, which can use only the names that law_syntax.py lists.

    Raises:
        LawError: when the law cannot be compiled.
    """
    known = {**FUNCTIONS, "__import__": lambda *_: math}
    space: dict[str, Any] = {"__name__": law.id, "__builtins__": known}
    try:
        exec(compile(law.source, f"{law.id}.py", "exec"), space)
        MODULES.add(f"{law.id}.")  # a law may call other functions of the same file
        inner = compiled(space[law.id])
        inner.compile((float64,) * len(law.arguments))
        returned = inner.nopython_signatures[0].return_type
        if not isinstance(returned, types.Float | types.Integer):
            raise LawError(f"must return a number, not {returned}")
        call = f"lambda {', '.join(ARGUMENTS)}: float({law.id}({', '.join(law.arguments)}))"
        function: Callable[..., float] = eval(call, space)
        compiled(function).compile((float64,) * len(ARGUMENTS))
    except LawError:
        raise
    except NumbaError as error:
        if MEMORY in str(error):
            raise LawError("makes arrays or lists; a law can use numbers only") from None
        raise LawError(f"does not compile: {_reason(error)}") from None
    except Exception as error:  # for example a division by zero in a constant of the file
        raise LawError(f"cannot be run: {type(error).__name__}: {error}") from None
    return function


def _reason(error: NumbaError) -> str:
    """Return the lines of numba's message that give the fault and its place, joined to one line."""
    text = re.sub(r"\x1b\[\d*m", "", str(error))  # removes the colours of the message
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    said = [line for line in lines if not line.startswith("Failed in")]
    place = re.findall(r"line (\d+)", text)
    return (said or lines)[0] + (f" (line {place[-1]})" if place else "")
