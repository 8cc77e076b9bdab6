"""Makes kernels: shared libraries with the compiled solver, which need neither Python nor numba.

Other folders of the package get kernels from library.py, which finds a prebuilt kernel or one in the cache,
or else compiles one.
"""
