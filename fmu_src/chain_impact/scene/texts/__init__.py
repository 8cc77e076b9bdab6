"""Names, units and angles as texts."""
