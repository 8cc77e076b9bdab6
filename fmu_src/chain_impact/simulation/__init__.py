"""A simulation in this process: of a whole scene, by hand, and with derivatives."""
