"""Checks across several keys of a scene, and of its signals."""
