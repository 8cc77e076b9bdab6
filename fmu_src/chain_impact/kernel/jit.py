"""How every function of the kernel is compiled."""

from numba import njit

# error_model="numpy": a division by zero gives inf, which the step control rejects, instead of raising;
# so the compiled kernel needs nothing of Python. Strict IEEE arithmetic (no fastmath) keeps results
# bit-equal on every machine.
jit = njit(error_model="numpy")
# where the compiler is to know an argument
inlined = njit(error_model="numpy", forceinline=True)
