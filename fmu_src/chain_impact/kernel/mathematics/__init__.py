"""Functions of real numbers, with the same bits on every machine: they do not call the C library."""
