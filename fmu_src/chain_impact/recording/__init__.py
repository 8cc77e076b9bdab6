"""A recorded motion (a recording): its table over time, its lists of impacts, and values from them."""
