"""The parts of numba that a new version of numba may change or move, because users are not meant to use them.

All other modules take these parts from here, and else only the documented names of ``numba`` and
``numba.extending``. collecting.py replaces attributes of these parts.
"""

from numba.core import base, callconv, cgutils, codegen, compiler_machinery, cpu
from numba.core.errors import NumbaError
from numba.core.imputils import lower_constant
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_global, signature
from numba.np import arrayobj

__all__ = [
    "AbstractTemplate",
    "AttributeTemplate",
    "Conversion",
    "NumbaError",
    "arrayobj",
    "base",
    "callconv",
    "cgutils",
    "codegen",
    "compiler_machinery",
    "cpu",
    "infer_global",
    "lower_constant",
    "signature",
]
