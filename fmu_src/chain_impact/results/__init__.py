"""Results of simulations: outputs, recordings, pictures."""
