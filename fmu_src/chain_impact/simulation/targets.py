"""Warnings of moving targets of drives whose target velocity stays 0, so that dampers brake the motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chain_impact.scene.texts.input_table import determined_quantities, is_motion
from chain_impact.scene.texts.names import name_parts
from chain_impact.simulation.polynomial_pieces import Pieces
from chain_impact.variables.prepared import PreparedScene

# [1] a target that is constant except for jumps is a list of positions to go to if it has at most this many
# jumps; with more jumps it is a motion, whose velocity is not 0
MOST_POSITIONS = 20


def still_dampers(prepared_scene: PreparedScene, names: Sequence[str], pieces: Pieces) -> list[str]:
    """Return a sentence for each target in ``names`` that is a motion while its target velocity stays 0.

    The damper of the drive then brakes this motion; without damping there is no sentence. ``_is_motion`` says
    which targets are motions. A target velocity stays 0 if neither ``names`` nor a signal gives it.

    Args:
        prepared_scene: the scene.
        names: the names of the inputs that the caller gives, in the order of the columns of ``pieces``.
        pieces: the inputs over time.
    """
    texts = []
    for m, name in enumerate(names):
        target, *rate = determined_quantities(name)
        if is_motion(name) or target != name or not rate:
            continue
        is_known = rate[0] in names or rate[0] in prepared_scene.signals_by_input
        if not is_known and _damping(prepared_scene, name) > 0.0 and _is_motion(pieces.powers[:, :, m]):
            texts.append(
                f"{name} changes over time, and {rate[0]} stays 0, so the damper brakes the motion: "
                f"give both, or {rate[0]} = 0 if it shall brake"
            )
    return texts


def _damping(prepared_scene: PreparedScene, name: str) -> float:
    """Return the damping [N·m·s/rad] or [N·s/m] of the drive whose target is the input ``name``."""
    chain, number = prepared_scene.scene.chain, name_parts(name).n
    if number:
        return chain.links[number - 1].joint_damping
    return chain.slider.damping if chain.slider else 0.0


def _is_motion(powers: np.ndarray) -> bool:
    """Return whether a target changes within a piece, or has more than MOST_POSITIONS jumps between pieces.

    ``powers``: the coefficients of the target's polynomial in each of P pieces, shape (P, K).
    """
    changes = np.count_nonzero(np.diff(powers[:, 0]))
    return bool(powers[:, 1:].any() or changes > MOST_POSITIONS)
