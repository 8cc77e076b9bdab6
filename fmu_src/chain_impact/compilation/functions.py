"""How numba compiles the kernel and a user's law, which are ordinary functions in Python."""

from __future__ import annotations

from functools import cache
from types import FunctionType
from typing import Any

from numba import float64, int64, njit, types
from numba.extending import models, register_model, typeof_impl

import chain_impact.kernel
from chain_impact.compilation import built_in
from chain_impact.compilation.compilers import HOOKS
from chain_impact.compilation.dual_numbers import DUAL, Dual
from chain_impact.compilation.numba_parts import lower_constant
from chain_impact.compilation.record_type import INSTANCE, TANGENT
from chain_impact.kernel import hooks
from chain_impact.kernel.chain.mass_matrix_solver import COMPLEX_RULES
from chain_impact.kernel.forces import user_law
from chain_impact.kernel.tangent import duals
from chain_impact.kernel.tangent.rules import DUAL_RULES

# error_model="numpy": a division by zero gives inf or NaN, not an exception, so the compiled kernel needs
# nothing from Python; the step control rejects a step with inf or NaN. Strict IEEE arithmetic (no fastmath)
# gives equal bits on every machine. No array of the kernel owns its memory, so numba need not count
# references (_nrt).
OPTIONS = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}
MODULES = {f"{chain_impact.kernel.__name__}."}
"""Names of packages and modules, each with a dot at the end. A function of these is compiled when another
function calls it."""
LAW_PRESENT, LAW_FORCE = "user_law_present", "user_law_force"
_TYPES = {"ptr": INSTANCE, "double": float64, "i64": int64}
HOOK_SIGNATURES: dict[FunctionType, Any] = {
    getattr(hooks, name): (types.void if result == "ptr" else _TYPES[result])(
        *(_TYPES[kind] for kind in arguments)
    )
    for name, (result, arguments, _) in HOOKS.items()
}
# function of the kernel → numba's type of the C function that replaces it in a library
EXTERNAL: dict[Any, types.Type] = {
    user_law.has_user_law: types.ExternalFunction(LAW_PRESENT, int64()),
    user_law.force: types.ExternalFunction(LAW_FORCE, float64(*[float64] * len(user_law.LAW_ARGUMENTS))),
    **{hook: types.ExternalFunction(hook.__name__, kind) for hook, kind in HOOK_SIGNATURES.items()},
}
_DUAL: dict[Any, Any] = DUAL_RULES
_COMPLEX: dict[Any, Any] = COMPLEX_RULES
# functions of the kernel for which dual_numbers.py and built_in.py write the code, in place of numba
BUILT_IN: set[Any] = {
    *(duals.value, duals.slope, duals.replace_slope, duals.dual_with_slope, duals.has_slope),
    *built_in.FUNCTIONS,
}


@cache
def compiled_function(function: FunctionType) -> Any:
    """Return numba's object for a function, which numba compiles when another function calls it."""
    return njit(forceinline=getattr(function, "inlined", False), **OPTIONS)(function)


class Function(types.Dispatcher):
    """numba's type for a function of the kernel or of a law.

    For dual or complex arguments, a call goes to the function that DUAL_RULES or COMPLEX_RULES has in place
    of this function, if there is one.
    """

    def __init__(self, function: FunctionType) -> None:
        self._function = function
        super().__init__(compiled_function(function))

    def _dispatcher_for(self, arguments: Any) -> types.Dispatcher:
        """Return the type of the function that is called for arguments of these types.

        It is the replacement in ``COMPLEX_RULES`` if an argument is a complex number, or in ``DUAL_RULES`` if
        an argument carries derivatives; without a replacement, it is the function itself.
        """
        rules = _DUAL if any(carries_derivatives(argument) for argument in arguments) else {}
        rules = _COMPLEX if types.complex128 in arguments else rules
        return types.Dispatcher(compiled_function(rules.get(self._function, self._function)))

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """Return the signature of the function for arguments of these types.

        If a function in ``_DUAL`` gets a dual number, all real arguments of the call become dual numbers.
        """
        if self._function in _DUAL and DUAL in args:
            args = tuple(DUAL if argument == float64 else argument for argument in args)
        return self._dispatcher_for(args).get_call_type(context, args, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return the compiled code of the function, or of its replacement, for a signature."""
        return self._dispatcher_for(sig.args).get_overload(sig)


def carries_derivatives(kind: types.Type) -> bool:
    """Return whether a type is that of a dual number, of an array of these, or of a record of them."""
    return (
        isinstance(kind, Dual)
        or getattr(kind, "dtype", None) == DUAL
        or getattr(kind, "what", "") == TANGENT.what
    )


register_model(Function)(models.OpaqueModel)


@typeof_impl.register(FunctionType)
def _type_of_function(function: FunctionType, _context: object) -> types.Type | None:
    if function in BUILT_IN or not f"{function.__module__}.".startswith(tuple(MODULES)):
        return None  # numba then finds the type of this function itself
    return EXTERNAL[function] if function in EXTERNAL else Function(function)


@lower_constant(Function)
def _no_value(context: Any, _builder: object, _type: Function, _value: object) -> Any:
    # a dummy: numba would write the function's address in this process into the code, which would differ
    # between runs
    return context.get_dummy_value()
