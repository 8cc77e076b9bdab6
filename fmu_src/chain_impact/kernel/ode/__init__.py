"""The integration of the equations: two methods, control of the size, the last step, its energy balance."""
