"""The compiled kernel: imports nothing but math, numpy, numba and itself."""
