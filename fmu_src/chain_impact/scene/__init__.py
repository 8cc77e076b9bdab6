"""The scene: a chain, its walls and how it starts, read from TOML into frozen dataclasses."""
