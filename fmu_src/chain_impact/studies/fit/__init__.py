"""Fits: parameters of a scene are estimated from measurements."""
