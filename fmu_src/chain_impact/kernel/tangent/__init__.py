"""Derivatives of a run with respect to parameters and inputs, computed with dual numbers beside the run."""
