"""The methods, their dense output, errors and sizes of steps, and which one is at work."""
