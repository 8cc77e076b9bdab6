"""The record that holds all data of a running simulation.

Each part has a function that returns its layout.
"""
