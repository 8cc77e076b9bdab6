"""The record that holds all data of a running simulation.

Each part has a function that returns its layout. Of the values that the kernel does not derive,
variables/filling.py sets those of the scene, variables/driving.py those of signals, and simulation/inputs.py
the inputs over time.
"""
