"""Pictures of sweeps: curves, dots, maps and histograms of results over varied parameters."""
