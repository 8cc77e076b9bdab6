"""The compiled kernel: imports nothing but math, numpy and itself."""
