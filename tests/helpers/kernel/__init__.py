"""The kernel's functions without the package around them.

- ``plain``: as plain Python, with a record of attributes
- ``columns``: tables of such a record
- ``stamps``: the same with a record that refuses values of another state
- ``kernel_calls``: calls of a compiled kernel as FMUs make them
- ``own_functions``: exp, log and the other functions of real numbers
"""
