"""The record of all data of a running simulation.

Each part has a function that returns its layout. The kernel derives some values. Other modules set the given
values: variables/filling.py the values of the scene, variables/signal_filling.py those of signals, and
simulation/inputs.py the inputs at each time.
"""
