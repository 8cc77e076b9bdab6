"""Scenes from tables that a test changes."""

from copy import deepcopy

from chain_impact.scene.scene import scene_from_dict


def changed(data, **tables):
    """Return a copy of the table of a scene, with keys of some tables added or replaced."""
    data = deepcopy(data)
    for name, table in tables.items():
        data[name] = {**data.get(name, {}), **table} if isinstance(table, dict) else table
    return data


def scene(data):
    return scene_from_dict(data, data["name"])
