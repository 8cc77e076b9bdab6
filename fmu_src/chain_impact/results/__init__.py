"""Results of simulations: recordings (recorded motions) with pictures, films and rankings."""
