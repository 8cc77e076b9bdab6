"""What a simulation gave: results, recordings, pictures."""
