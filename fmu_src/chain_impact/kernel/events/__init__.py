"""Events: their location in a step, their handlers with impacts and release, and the log of contacts."""
