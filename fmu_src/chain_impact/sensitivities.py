"""Runs with derivatives, for scripts that import them from here; ``chain_impact`` has them, too."""

from chain_impact.simulation.derivatives import Differentiated, DifferentiatedRun

__all__ = ["Differentiated", "DifferentiatedRun"]
