"""What of a robot's file a scene does not have, or has otherwise: one line each, the largest effect first."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum

NEGLIGIBLE = 0.02  # of a length, up to which a shift is no warning
SHOWN = 6  # names in a line
PLURALS = {"body": "bodies", "equality": "equalities", "link of joint": "links of joints"}


class Effect(IntEnum):
    """What a difference changes; the first is told first."""

    MASS = 0
    MOTION = 1
    CONTACT = 2
    NONE = 3


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Something that a scene does not have, or has otherwise.

    Attributes:
        kind: of the element of the file, as ``joint``.
        name: of the element, empty if the kind says all.
        text: the rest of the sentence.
        effect: what it changes.
        size: how much, as a part of a length, where that is known; the larger, the earlier.
        joints: names of joints, of which one must move if there is to be an effect; none: there is one.
        bodies: positions of bodies that must not all be in the same link if there is to be an effect, −1 for
            the world; none: there is one.
    """

    kind: str
    name: str = ""
    text: str
    effect: Effect
    size: float = 0.0
    joints: frozenset[str] = frozenset()
    bodies: frozenset[int] = frozenset()

    @property
    def warns(self) -> bool:
        """Whether the robot moves otherwise in the scene, by more than what is negligible."""
        return self.effect == Effect.MOTION or self.size > NEGLIGIBLE

    def matters(self, held: Collection[str], owner: dict[int, int]) -> bool:
        """Whether it has an effect, if some joints are held, and each body is part of a link, −1 for none."""
        if self.joints and self.joints <= set(held):
            return False
        return not self.bodies or len({owner[b] for b in self.bodies}) > 1


def of_joint(name: str, text: str, effect: Effect) -> Difference:
    """Return a difference of a joint, which has no effect where the joint is held."""
    return Difference(kind="joint", name=name, text=text, effect=effect, joints=frozenset([name]))


@contextmanager
def heard(package: str) -> Iterator[list[Difference]]:
    """Keep what a package warns of, as differences."""
    told: list[Difference] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield told
    for message in dict.fromkeys(" ".join(str(one.message).split()) for one in caught):
        told.append(Difference(kind=package, text=message, effect=Effect.NONE))


def lines(differences: Iterable[Difference], *, warning: bool) -> list[str]:
    """Return the warnings, or all others, a sentence each, those with the largest effect first."""
    ordered = sorted(differences, key=lambda one: (one.effect, -one.size))
    names: dict[tuple[str, str], list[str]] = {}
    for one in ordered:
        if one.warns == warning:
            names.setdefault((one.kind, one.text), []).append(one.name)
    return [line(kind, list(dict.fromkeys(found)), text) for (kind, text), found in names.items()]


def line(kind: str, names: Sequence[str], text: str, shown: int = SHOWN) -> str:
    """Return a sentence on some elements of a kind."""
    if len(names) > 1:
        kind = PLURALS.get(kind, f"{kind}s")
    return f"{' '.join(filter(None, (kind, few(names, shown))))}: {text}"


def few(names: Sequence[str], shown: int = SHOWN) -> str:
    """Return some names, and how many more there are."""
    more = f" and {len(names) - shown} more" if len(names) > shown else ""
    return f"{', '.join(names[:shown])}{more}"
