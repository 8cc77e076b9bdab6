"""A scene as Python and notebooks show it: bodies, a small drawing, and text."""
