"""The points and joints at which forces act on the chain, the chain's response there, and constraints."""
