"""The compiled kernel, which imports only math, numpy and itself."""
