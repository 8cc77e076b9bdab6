"""The scene, read from TOML into frozen dataclasses: chain, walls, contact, initial state and more."""
