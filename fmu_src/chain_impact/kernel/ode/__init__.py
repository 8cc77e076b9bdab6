"""The integration of the equations: two methods, step sizes, the last step, and its energy balance."""
