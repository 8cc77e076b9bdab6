"""The data of studies, which pictures draw: the runs of sweeps and of compared laws."""
