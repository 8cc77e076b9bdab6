"""Derivatives beside the run."""
