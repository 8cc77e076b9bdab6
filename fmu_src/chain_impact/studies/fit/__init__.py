"""Fits: estimates of a scene's parameters from measurements."""
