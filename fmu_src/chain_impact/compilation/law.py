"""A user's own contact law as a C function, which is linked to a kernel.

In a law, exp, expm1, log, log1p, pow, sin and cos are the kernel's own functions, whose results have the same
bits on every machine. Most other functions of ``math`` are those of the platform's C library or, in a
browser, of ``Math``.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from types import ModuleType
from typing import Any

from numba import float64, types
from numba.extending import lower_builtin

from chain_impact.compilation.functions import LAW_FORCE, MODULES, compiled_function
from chain_impact.compilation.numba_parts import NumbaError
from chain_impact.kernel.forces.user_law import LAW_ARGUMENTS
from chain_impact.kernel.mathematics import angles, exponentials, logarithms, powers
from chain_impact.user_laws.law_file import LawError, UserLaw
from chain_impact.user_laws.law_syntax import FUNCTIONS, MATH

MEMORY = "NRT required"  # words in numba's message on a function that allocates memory
MATHEMATICS = ModuleType(math.__name__)
"""The module ``math`` that a user's law gets; functions of the kernel replace some of Python's functions."""
vars(MATHEMATICS).update(
    {name: getattr(math, name) for name in MATH}
    | {name: getattr(exponentials, name) for name in ("exp", "expm1")}
    | {name: getattr(logarithms, name) for name in ("log", "log1p")}
    | {"pow": powers.power, "sin": angles.sine, "cos": angles.cosine}
)


def _lower_power(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return context.compile_internal(builder, powers.power, signature, arguments)


for _operation in (pow, operator.pow, operator.ipow):
    lower_builtin(_operation, float64, float64)(_lower_power)


def law_entry(law: UserLaw) -> dict[str, tuple[Any, Callable[..., Any]]]:
    """Return the C function of a law as a dict with one entry: name → (numba's signature, Python function).

    Raises:
        LawError: when the law cannot be compiled.
    """
    numbers = (float64,) * len(LAW_ARGUMENTS)
    return {LAW_FORCE: (float64(*numbers), _checked_function(law))}


def _checked_function(law: UserLaw) -> Callable[..., float]:
    """Return the law as a Python function that takes all of ``LAW_ARGUMENTS``, and that numba can compile.

    Python runs the file of the law, to evaluate its constants; the file can use only the names that
    law_syntax.py lists.

    Raises:
        LawError: when the file cannot be run, or the law cannot be compiled or returns no number.
    """
    names = {**FUNCTIONS, "__import__": lambda *_: MATHEMATICS}
    space: dict[str, Any] = {"__name__": law.id, "__builtins__": names}
    try:
        exec(compile(law.source, f"{law.id}.py", "exec"), space)
        # because of this entry, numba compiles the functions of the law's file that the law calls
        MODULES.add(f"{law.id}.")
        compiled_law = compiled_function(space[law.id])
        compiled_law.compile((float64,) * len(law.arguments))
        returned = compiled_law.nopython_signatures[0].return_type
        if not isinstance(returned, types.Float | types.Integer):
            raise LawError(f"must return a number, not {returned}")
        call_code = f"lambda {', '.join(LAW_ARGUMENTS)}: float({law.id}({', '.join(law.arguments)}))"
        function: Callable[..., float] = eval(call_code, space)
        compiled_function(function).compile((float64,) * len(LAW_ARGUMENTS))
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
    """Return the line of numba's message that names the fault, and the message's last line number, if any."""
    # this removes the codes that colour the message in a terminal
    text = re.sub(r"\x1b\[\d*m", "", str(error))
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    messages = [line for line in lines if not line.startswith("Failed in")]
    line_numbers = re.findall(r"line (\d+)", text)
    return (messages or lines)[0] + (f" (line {line_numbers[-1]})" if line_numbers else "")
