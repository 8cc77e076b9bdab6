"""Simulation in this process: whole runs of a scene, steps by hand, and derivatives."""
