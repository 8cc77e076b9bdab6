"""Chains with dampings over many orders of magnitude."""

import numpy as np

from chain_impact.kernel.chain.inputs import apply_inputs
from chain_impact.kernel.chain.kinematics import set_link_vectors
from chain_impact.kernel.initialize import derive_chain, derive_drives
from chain_impact.scene.scene import scene_from_dict
from tests.helpers.kernel.plain import record_of
from tests.kernel.chains import random_links


def random_chain(rng, count, base, largest):
    """Return an asymmetric chain with dampings over many orders of magnitude, some of them zero."""
    links = random_links(rng, count)
    for link in links:
        link["joint_damping"] = largest * 10.0 ** -rng.uniform(0.0, 6.0) * (rng.random() < 0.8)
    links[0]["joint_damping"] *= base == "pinned"
    table = {"name": "Damped", "chain": {"base": base, "links": links}, "contact": {"points": []}}
    return scene_from_dict(table | {"initial": {"angles": [0.0] * count}}, "damped")


def prepared(scene, angles):
    """Return the record of a chain, as plain Python takes it, with its link vectors."""
    d = record_of(scene)
    derive_chain(d)
    apply_inputs(d)
    derive_drives(d)
    set_link_vectors(d, np.array([0.0, 0.0, *angles]))
    return d
