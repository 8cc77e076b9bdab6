"""The record of all data of a running simulation.

Each part of the record has a function that returns the layout of this part. Modules outside the kernel set
the given values: variables/filling.py the values of the scene, variables/signal_filling.py those of signals,
and simulation/input_schedule.py the inputs at each time. The kernel derives the other values.
"""
