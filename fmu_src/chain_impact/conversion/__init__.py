"""Scenes from URDF and MJCF, the formats of robots, and back to MJCF."""
