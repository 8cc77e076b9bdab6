"""Results of simulations: recordings that also have pictures, films and rankings."""
