"""The kernel as a shared library, which needs neither Python nor numba.

Other folders get kernels from library.py: ready, cached, or compiled when asked for.
"""
