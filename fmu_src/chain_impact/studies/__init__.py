"""Studies with many runs of a scene: sweeps, fits, comparisons of contact laws, animations, accuracy."""
