"""What others see of a scene: its variables under the names of the FMU, and its record with their values."""
