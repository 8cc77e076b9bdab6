"""Conversion of the robot formats URDF and MJCF to scenes, and of scenes to MJCF."""
