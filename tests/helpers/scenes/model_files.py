"""Tables in the folders of models: inputs and reference results; co-simulations by the models' scripts."""

import csv
import functools
import subprocess
import sys

import numpy as np

from chain_impact.scene.files.models import models_folder

CO_SIMULATED = {
    "controlled_arm": {"inputs.csv", "controller.py", "co_simulation.py", "masters.py"},
    "carried_arm": {"carriage.py", "co_simulation.py"},
    "cart_pole": {"balancer.py", "co_simulation.py"},
}


@functools.cache
def table(model, file):
    """Return the times, and the other columns by name, of a CSV file of a model."""
    columns = columns_of(models_folder() / model / file)
    return columns.pop("time"), columns


def columns_of(path):
    """Return the columns of a CSV file."""
    with path.open(newline="") as lines:
        names, *rows = csv.reader(lines)
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


def co_simulated(model, folder, *arguments):
    """Return the columns that the co-simulation of a model writes; its script runs in another process."""
    script = models_folder() / model / "co_simulation.py"
    subprocess.run([sys.executable, script, "-o", folder, *arguments], check=True, capture_output=True)
    (file,) = folder.glob("*.csv")
    return columns_of(file)


def reference(model):
    """Return the times and the other columns of a model's stored reference."""
    return table(model, "reference.csv")


def inputs_of(model):
    """Return the inputs of a model's file inputs.csv, in the form that ``simulate`` takes; {} without it."""
    if "inputs.csv" not in CO_SIMULATED.get(model, ()):
        return {}
    time, columns = table(model, "inputs.csv")
    return {name: (time, values) for name, values in columns.items()}
