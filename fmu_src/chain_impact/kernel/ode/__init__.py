"""The integration of ẏ = f(y): two methods, step sizes, the last step and its dense output, energy checks."""
