"""The compiled kernel, which imports only the standard library, NumPy and itself."""
