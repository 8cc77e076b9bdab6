"""A recorded motion: its table, its lists of impacts and changes, and what is computed from them."""
