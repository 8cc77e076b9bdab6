"""The panels over time: energies, dry friction, impacts, and the force of one impact."""
