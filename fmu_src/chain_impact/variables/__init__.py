"""The variables of a scene with their names in the FMU, and the record of an instance with their values."""
