"""Links that fold on the stiffest floor."""

from __future__ import annotations

from typing import Any

from chain_impact.scene.scene import load_scene, with_values
from chain_impact.simulation.instance import Instance
from tests.helpers.scenes.turned import turned


def touching(tolerance: float, changes: dict[Any, Any] | None = None, turn: float = 0.0) -> Instance:
    """Return an instance of touching links at a tolerance, with changed values, rotated by an angle [rad]."""
    scene = with_values(load_scene("four_link_box"), changes or {})
    stiff = {("contact", "stiffness"): 1e12, ("contact", "restitution"): 0.05}
    return Instance(turned(with_values(scene, stiff | {("solver", "tolerance"): tolerance}), turn))
