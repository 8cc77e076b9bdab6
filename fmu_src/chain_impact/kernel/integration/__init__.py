"""The integration methods, their dense output, error and step-size control, and the choice of method."""
