"""The data of studies, which pictures draw: runs of sweeps and of compared laws, and ranked effects."""
