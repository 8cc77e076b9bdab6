"""The contact laws, their registry, and a user's law."""
