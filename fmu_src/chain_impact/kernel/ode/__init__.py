"""The integration of the equations: two methods, the control of the step size, the last step, its energy."""
