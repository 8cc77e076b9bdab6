"""The variables of a scene with their names in the FMU, and a run's record with their values."""
