"""The kernel's functions without the package around them.

- ``plain``: as plain Python, with a record of attributes
- ``columns``: tables of such a record
- ``stamps``: the same with a record that refuses values of another state
- ``kernel_calls``: the calls of a compiled kernel that only FMUs make
- ``own_functions``: exp, log and the other functions of real numbers
"""
