"""The effects of parameters on one quantity of a run."""
