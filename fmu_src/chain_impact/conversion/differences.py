"""The differences between a robot and its scene, each a line of text, with the largest effect first."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum

from chain_impact.recording.text import few

# a difference whose `size` is at most NEGLIGIBLE gives no warning, unless its `effect` is MOTION
NEGLIGIBLE = 0.02
LINE_NAMES = 6  # largest number of names in a line; the line counts further ones: "and 3 more"
WARNING, DIFFERS, LEFT_OUT = "warning", "differs", "left out"  # titles under which differences are reported
PLURALS = {"body": "bodies", "equality": "equalities", "link of joint": "links of joints"}


class Effect(IntEnum):
    """What a difference changes, in the order in which differences are reported."""

    MASS = 0
    MOTION = 1
    CONTACT = 2
    NONE = 3


@dataclass(frozen=True, kw_only=True)
class Difference:
    """A part of a robot's file that the scene does not have, or has in another form.

    Attributes:
        kind: the kind of element in the file, such as ``joint``.
        name: the name of the element; "" if ``kind`` says enough.
        text: the rest of the sentence on the difference, after kind and name.
        effect: what the difference changes.
        differs: True if the scene has the part in another form, False if the scene does not have it.
        size: how large the difference is, such as a distance divided by the length of its link; 0 if unknown.
            Differences of equal ``effect`` are reported from the largest one.
        joints: names of joints; if there are names, and all these joints are held, the difference has no
            effect and is not reported.
        bodies: indices of bodies, −1 for the world; if there are indices, and all these bodies belong to the
            same link or all to none, the difference has no effect and is not reported.
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
        """The title under which the difference is reported.

        It is WARNING if ``effect`` is MOTION or ``size`` exceeds NEGLIGIBLE, else DIFFERS or LEFT_OUT.
        """
        if self.effect == Effect.MOTION or self.size > NEGLIGIBLE:
            return WARNING
        return DIFFERS if self.differs else LEFT_OUT

    def matters(self, held: Collection[str], link_of: dict[int, int]) -> bool:
        """Return whether the difference has an effect on the scene, and so must be reported.

        Args:
            held: names of the joints that are held.
            link_of: body → index of its link, −1 for a body in no link.
        """
        if self.joints and self.joints <= set(held):
            return False
        return not self.bodies or len({link_of[b] for b in self.bodies}) > 1


def of_joint(name: str, text: str, effect: Effect, *, differs: bool = False) -> Difference:
    """Return a difference of the joint ``name``, which is not reported if this joint is held."""
    about = frozenset([name])
    return Difference(kind="joint", name=name, text=text, effect=effect, differs=differs, joints=about)


@contextmanager
def collected_warnings(package: str) -> Iterator[list[Difference]]:
    """Context that makes differences of kind ``package`` of Python warnings; it fills the list at its end."""
    differences: list[Difference] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield differences
    for message in dict.fromkeys(" ".join(str(warning.message).split()) for warning in caught):
        differences.append(Difference(kind=package, text=message, effect=Effect.NONE))


def lines(differences: Iterable[Difference], title: str) -> list[str]:
    """Return a sentence for each group of differences with this ``title``, the same kind and the same text.

    The sentences are in the order of ``Effect``; for the same effect, the largest difference comes first.
    """
    ordered = sorted(differences, key=lambda difference: (difference.effect, -difference.size))
    names: dict[tuple[str, str], list[str]] = {}
    for difference in ordered:
        if difference.title == title:
            names.setdefault((difference.kind, difference.text), []).append(difference.name)
    return [line(kind, list(dict.fromkeys(of_kind)), text) for (kind, text), of_kind in names.items()]


def line(kind: str, names: Sequence[str], text: str, shown: int = LINE_NAMES) -> str:
    """Return the sentence "<kind> <names>: <text>", with up to ``shown`` names and a count of the others."""
    if len(names) > 1:
        kind = PLURALS.get(kind, f"{kind}s")
    return f"{' '.join(filter(None, (kind, few(names, shown))))}: {text}"
