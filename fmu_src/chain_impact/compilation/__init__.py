"""The kernel as a shared library, which needs neither Python nor numba.

library.py is the door: who asks for a kernel gets one that is ready, cached or compiled just now.
"""
