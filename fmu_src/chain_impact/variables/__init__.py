"""The variables of a scene under their names in the FMU, and the record of an instance with their values."""
