"""Parameters of a scene from measurements."""
