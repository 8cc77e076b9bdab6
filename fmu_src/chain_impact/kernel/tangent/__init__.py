"""Derivatives of a run with respect to parameters; dual numbers compute them together with the run."""
