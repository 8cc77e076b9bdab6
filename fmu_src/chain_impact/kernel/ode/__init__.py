"""The integration of the equations: two methods, step size control, the last step, and its energy balance."""
