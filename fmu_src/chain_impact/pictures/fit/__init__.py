"""The picture of a fit: measured columns with the model, and the estimates of the parameters."""
