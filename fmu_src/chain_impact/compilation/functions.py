"""How numba takes the kernel, and a user's law: as plain functions of Python."""

from __future__ import annotations

from functools import cache
from types import FunctionType
from typing import Any

from numba import float64, int64, njit, types
from numba.core.imputils import lower_constant
from numba.extending import models, register_model, typeof_impl

import chain_impact.kernel
from chain_impact.kernel.laws import user_law

# error_model="numpy": a division by zero gives inf, which the step control rejects, instead of raising. So
# the compiled kernel needs nothing of Python. Strict IEEE arithmetic (no fastmath) keeps results bit-equal on
# every machine. No array of the kernel owns its memory: there are no references to count (_nrt).
OPTIONS = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}
MODULES = {f"{chain_impact.kernel.__name__}."}
"""Packages and modules, with a dot at the end, whose functions are compiled when another one calls them."""
LAW_PRESENT, LAW_FORCE = "user_law_present", "user_law_force"
# what a library gets from elsewhere when it is linked
EXTERNAL: dict[Any, types.Type] = {
    user_law.present: types.ExternalFunction(LAW_PRESENT, int64()),
    user_law.force: types.ExternalFunction(LAW_FORCE, float64(*[float64] * len(user_law.ARGUMENTS))),
}


@cache
def compiled(function: FunctionType) -> Any:
    """The function as one that numba compiles."""
    return njit(forceinline=getattr(function, "inlined", False), **OPTIONS)(function)


class Function(types.Dispatcher):
    """The type of a function of the kernel."""


register_model(Function)(models.OpaqueModel)


@typeof_impl.register(FunctionType)
def _type_of_function(function: FunctionType, _context: object) -> types.Type | None:
    if not f"{function.__module__}.".startswith(tuple(MODULES)):
        return None  # numba knows some functions by themselves
    return EXTERNAL[function] if function in EXTERNAL else Function(compiled(function))


@lower_constant(Function)
def _no_value(context: Any, _builder: object, _type: Function, _value: object) -> Any:
    # numba would write down where its object stands in the memory of this process
    return context.get_dummy_value()
