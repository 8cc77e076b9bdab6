"""From a scene to files that other tools import."""
