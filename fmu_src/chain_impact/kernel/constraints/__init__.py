"""The rows (places and directions) at which forces act on the chain, its response there, and constraints."""
