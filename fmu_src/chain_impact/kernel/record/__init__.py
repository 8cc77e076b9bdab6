"""The record of all data of a running simulation.

Each part has a function that returns its layout. The kernel derives some values. Of the others,
variables/filling.py sets the scene's values, variables/driving.py those of signals, and simulation/inputs.py
the inputs at each time.
"""
