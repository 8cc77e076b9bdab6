"""The record that holds all data of a running simulation.

Each part has a function that returns its layout. In a settable part, variables/filling.py sets all values
that the kernel does not derive.
"""
