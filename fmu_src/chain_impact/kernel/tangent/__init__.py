"""Derivatives of a run with respect to parameters, computed together with it in dual numbers."""
