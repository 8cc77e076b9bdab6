"""Makes the kernel (the compiled solver): a shared library, which needs neither Python nor numba.

Other folders of the package get kernels from library.py, which finds a ready kernel or one in the cache, or
compiles one.
"""
