"""Measurements of speed and accuracy: ``python -m benchmarks NAME`` runs the module NAME."""
