"""Studies that run a scene many times: sweeps, fits, comparisons of laws, animations, accuracy."""
