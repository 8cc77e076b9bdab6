"""The differences between a robot's file and its scene, each as one line, with the largest effect first."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum

from chain_impact.recording.text import few

# the largest relative size of a difference (`Difference.size`) that is negligible, and so gives no warning
NEGLIGIBLE = 0.02
LINE_NAMES = 6  # largest number of names in a line
WARNING, DIFFERS, LEFT_OUT = "warning", "differs", "left out"  # the titles of reports
PLURALS = {"body": "bodies", "equality": "equalities", "link of joint": "links of joints"}


class Effect(IntEnum):
    """The effects that a difference may have, in the order in which they are reported."""

    MASS = 0
    MOTION = 1
    CONTACT = 2
    NONE = 3


@dataclass(frozen=True, kw_only=True)
class Difference:
    """A part of a robot's file that the scene does not have, or has in another form.

    Attributes:
        kind: the kind of element in the file, such as ``joint``.
        name: the name of the element; empty if the kind suffices.
        text: the sentence on the difference, after kind and name.
        effect: the effect of the difference.
        differs: True if the scene has the part in another form, False if the scene does not have it.
        size: how large the difference is relative to the link, such as a distance divided by the link's
            length; 0 if unknown. The largest difference comes first.
        joints: names of joints; the difference has no effect if all these joints are held. Without names it
            always has an effect.
        bodies: indices of bodies, −1 for the world; the difference has no effect if all these bodies are in
            the same link. Without indices it always has an effect.
    """

    kind: str
    name: str = ""
    text: str
    effect: Effect
    differs: bool = False
    size: float = 0.0
    joints: frozenset[str] = frozenset()
    bodies: frozenset[int] = frozenset()

    @property
    def title(self) -> str:
        """The title of the report; a warning if the motion changes by more than a negligible amount."""
        if self.effect == Effect.MOTION or self.size > NEGLIGIBLE:
            return WARNING
        return DIFFERS if self.differs else LEFT_OUT

    def matters(self, held: Collection[str], link_of: dict[int, int]) -> bool:
        """Return whether the difference has an effect on the scene.

        Args:
            held: names of the joints that are held.
            link_of: body → index of its link, −1 for a body in no link.
        """
        if self.joints and self.joints <= set(held):
            return False
        return not self.bodies or len({link_of[b] for b in self.bodies}) > 1


def of_joint(name: str, text: str, effect: Effect, *, differs: bool = False) -> Difference:
    """Return a difference of a joint, which has no effect if the joint is held."""
    about = frozenset([name])
    return Difference(kind="joint", name=name, text=text, effect=effect, differs=differs, joints=about)


@contextmanager
def collected_warnings(package: str) -> Iterator[list[Difference]]:
    """Collect the warnings in the ``with`` block as differences; the list is filled at its end."""
    differences: list[Difference] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield differences
    for message in dict.fromkeys(" ".join(str(warning.message).split()) for warning in caught):
        differences.append(Difference(kind=package, text=message, effect=Effect.NONE))


def lines(differences: Iterable[Difference], title: str) -> list[str]:
    """Return sentences on the differences that have this ``title`` in the report.

    The sentences are in the order of ``Effect``; for one effect, the largest difference is first. Differences
    that differ only in their names share a sentence.
    """
    ordered = sorted(differences, key=lambda difference: (difference.effect, -difference.size))
    names: dict[tuple[str, str], list[str]] = {}
    for difference in ordered:
        if difference.title == title:
            names.setdefault((difference.kind, difference.text), []).append(difference.name)
    return [line(kind, list(dict.fromkeys(of_kind)), text) for (kind, text), of_kind in names.items()]


def line(kind: str, names: Sequence[str], text: str, shown: int = LINE_NAMES) -> str:
    """Return a sentence on some elements of a kind."""
    if len(names) > 1:
        kind = PLURALS.get(kind, f"{kind}s")
    return f"{' '.join(filter(None, (kind, few(names, shown))))}: {text}"
