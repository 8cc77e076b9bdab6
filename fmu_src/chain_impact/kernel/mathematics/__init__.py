"""Functions of real numbers, with the same bits on every machine: they call nothing of its C library."""
