"""The structure of a scene: the properties that decide its variables, their owners and the record's size.

The twin in JavaScript is pages/browser/scene/owners.js.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from chain_impact.kernel.record.counts import COUNTS, Counts
from chain_impact.scene.facts import LISTS, SceneFacts
from chain_impact.scene.scene import Scene
from chain_impact.scene.signals import SignalInput, signal_inputs_of
from chain_impact.variables.owners import Owner, numbers_of_scene, owners_of


@dataclass(frozen=True)
class Structure:
    """All properties of a scene that decide which outputs exist, without the values of parameters.

    Scenes with equal structures have the same outputs. Nothing may change ``numbers`` and ``lists``.

    Attributes:
        numbers: name → number, for the facts, counts and lengths of lists of the scene
            (owners.numbers_of_scene).
        lists: name of a list of the scene (scene/facts.py) → the members of this list.
        signals: the inputs that signals drive, in the order of the record.
    """

    numbers: Mapping[str, int]
    lists: Mapping[str, Sequence[Mapping[str, Any]]]
    signals: tuple[SignalInput, ...]

    def __hash__(self) -> int:
        """Return the hash of the numbers in ``numbers``, which are the same in equal structures."""
        return hash(tuple(self.numbers.values()))

    @cached_property
    def counts(self) -> Counts:
        """The counts at the start of the scene's record."""
        return Counts(*(self.numbers[name] for name in COUNTS))

    @property
    def signal_quantities(self) -> dict[str, tuple[int, int]]:
        """Quantity that a signal determines → (index k in ``signals``, index in ``signals[k].outputs``).

        If two signals determine it, as a target velocity, the later one counts.
        """
        positions: dict[str, tuple[int, int]] = {}
        for row, signal in enumerate(self.signals):
            positions |= {name: (row, order) for order, name in enumerate(signal.outputs) if name}
        return positions

    def owners(self, kind: str) -> list[Owner]:
        """Return the owners of a kind, a key of ``owners.OWNER_KINDS``, in the order of their variables."""
        return owners_of(kind, self.numbers, self.lists)


def structure_of(scene: Scene) -> Structure:
    """Return the structure of a scene."""
    facts = SceneFacts(scene)
    return Structure(numbers_of_scene(facts), {name: facts[name] for name in LISTS}, signal_inputs_of(scene))
