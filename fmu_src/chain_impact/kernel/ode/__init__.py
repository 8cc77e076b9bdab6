"""The integration of the equations: two methods, step sizes, the last step, the check of a step's energy."""
