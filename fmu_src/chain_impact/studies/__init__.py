"""Studies from several runs of a scene: sweeps, fits, comparisons of laws, animations, accuracy."""
