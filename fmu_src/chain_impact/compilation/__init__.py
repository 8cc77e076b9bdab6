"""The kernel as a shared library, which needs neither Python nor numba.

Other folders of the package get kernels from library.py, which finds a ready or a cached kernel, or compiles
one.
"""
