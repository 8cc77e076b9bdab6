"""The tables of scene keys: dataclasses whose fields are the keys, with defaults, ranges and units."""
