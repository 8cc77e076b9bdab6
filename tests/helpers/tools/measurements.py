"""Artificial measurements: results of a simulation with noise of a known size."""

import numpy as np

from chain_impact import load_scene, simulate

FREE = ("contact.stiffness", "contact.restitution", "initial.angular_velocity[3]")
TRUE = (1e8, 0.7, 1.5)
TIP = ("point[4].x", "point[4].y")
NOISE = 1e-3  # m


def scene(**starts):
    """Return the four-link box; ``K``, ``e`` and ``w`` are other values of the parameters FREE, in order."""
    values = dict(
        zip(FREE, (starts.get(name, true) for name, true in zip("Kew", TRUE, strict=True)), strict=True)
    )
    return load_scene("four_link_box").with_values(values)


def motion(stop, count=200, seed=0, noise=NOISE):
    """Return columns with the tip's path plus noise [m] at ``count`` times after 0, and the exact result."""
    result = simulate(scene(), stop_time=stop, output_step=stop / count)
    random = np.random.default_rng(seed)
    columns = {name: result[name][1:] + noise * random.standard_normal(count) for name in TIP}
    return {"time": result.time[1:], **columns}, result


def impacts(result, names, noise=0.0, seed=0):
    """Return columns with the number, the wall and the named quantities of all impacts.

    The quantities have relative noise; the name "duration" is possible, too.
    """
    random = np.random.default_rng(seed)
    rows = result.impacts
    values = {name: rows["end"] - rows["onset"] if name == "duration" else rows[name] for name in names}
    noisy = {
        name: value * (1.0 + noise * random.standard_normal(len(rows))) for name, value in values.items()
    }
    walls = [result.scene.wall_names[wall] for wall in rows["wall"]]
    return {"impact": np.arange(len(rows)) + 1, "wall": walls, **noisy}
