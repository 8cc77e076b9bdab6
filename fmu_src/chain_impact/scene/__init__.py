"""The scene: a chain, walls and an initial state, read from TOML into frozen dataclasses."""
