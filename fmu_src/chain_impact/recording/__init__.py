"""A recorded motion: its table, its lists of impacts and changes, and values that are computed from these."""
