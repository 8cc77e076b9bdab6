"""Results of simulations: recordings with their pictures, films and rankings."""
