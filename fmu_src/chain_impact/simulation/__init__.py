"""Simulation in this process: whole runs of a scene, steps that a program controls, and derivatives."""
