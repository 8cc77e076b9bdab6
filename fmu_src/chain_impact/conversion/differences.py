"""The differences between a robot and its scene, and the lines of text that tell of them."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum

from chain_impact.text import names_text

# [1] a `size` up to which a difference gives no warning, unless its `effect` is MOTION or LATER_MOTION
NEGLIGIBLE_SIZE = 0.02
LINE_NAMES = 6  # largest number of names in a line of text; further names are only counted: "and 3 more"
WARNING, DIFFERS, LEFT_OUT = "warning", "differs", "left out"  # titles under which differences are reported
PLURALS = {"body": "bodies", "equality": "equalities", "link of joint": "links of joints"}


class SceneAspect(IntEnum):
    """The part of the scene that a difference changes; reports are in the order of these numbers.

    MOTION changes from the start on, LATER_MOTION only beyond some angle, speed or force, or by an input.
    """

    MASS = 0
    MOTION = 1
    LATER_MOTION = 2
    CONTACT = 3
    NONE = 4


@dataclass(frozen=True, kw_only=True)
class Difference:
    """A part of a robot's file that the scene does not have, or that the scene has in another form.

    Attributes:
        kind: the kind of element in the file, such as ``joint``.
        name: the name of the element; "" if ``kind`` says enough.
        text: the rest of the sentence on the difference, after kind and name.
        effect: the part of the scene that the difference changes.
        differs: True if the scene has the part in another form, False if the scene does not have it.
        size: the size of the difference as a part of 1, such as a distance divided by the length of a link;
            0 if unknown. Of differences with equal ``effect``, the largest is reported first.
        joints: names of joints. If there are names, and all these joints are held, the difference has no
            effect and is not reported.
        bodies: indices of bodies, −1 for the world. If there are indices, and all these bodies belong to one
            link, or all to no link, the difference has no effect and is not reported.
    """

    kind: str
    name: str = ""
    text: str
    effect: SceneAspect
    differs: bool = False
    size: float = 0.0
    joints: frozenset[str] = frozenset()
    bodies: frozenset[int] = frozenset()

    @property
    def title(self) -> str:
        """The title under which the difference is reported.

        It is WARNING if ``effect`` is MOTION or LATER_MOTION, or ``size`` exceeds NEGLIGIBLE_SIZE. For any
        other difference it is DIFFERS if ``differs``, else LEFT_OUT.
        """
        changes_motion = self.effect in (SceneAspect.MOTION, SceneAspect.LATER_MOTION)
        if changes_motion or self.size > NEGLIGIBLE_SIZE:
            return WARNING
        return DIFFERS if self.differs else LEFT_OUT

    def matters(self, held_joints: Collection[str], link_of: dict[int, int]) -> bool:
        """Return whether the difference has an effect on the scene, and so must be reported.

        See ``joints`` and ``bodies``.

        Args:
            held_joints: names of the joints that are held.
            link_of: index of a body → index of its link, −1 for no link. The body −1 is the world.
        """
        if self.joints and self.joints <= set(held_joints):
            return False
        return not self.bodies or len({link_of[b] for b in self.bodies}) > 1


def joint_difference(name: str, text: str, effect: SceneAspect, *, differs: bool = False) -> Difference:
    """Return a difference of the joint ``name``, which is not reported if this joint is held."""
    joint_names = frozenset([name])
    return Difference(kind="joint", name=name, text=text, effect=effect, differs=differs, joints=joint_names)


@contextmanager
def collect_warnings(package: str) -> Iterator[list[str]]:
    """Context manager that yields a list, and at its end fills it with notes on Python warnings.

    There is one note, "<package> warns: …", for each different text of a warning in the ``with`` block, but
    none for a text with which another one begins. The warnings are not shown.
    """
    notes: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield notes
    texts = dict.fromkeys(" ".join(str(warning.message).split()) for warning in caught)
    whole_texts = [
        text
        for text in texts
        if not any(longer_text.startswith(text) for longer_text in texts if longer_text != text)
    ]
    notes.extend(f"{package} warns: {text}" for text in whole_texts)


def difference_lines(differences: Iterable[Difference], title: str) -> list[str]:
    """Return the sentences on the differences with the title ``title``: one for each kind and text.

    The sentences are in the order of ``SceneAspect``; of the same effect, the largest is first.
    """
    ordered_differences = sorted(differences, key=lambda difference: (difference.effect, -difference.size))
    names: dict[tuple[str, str], list[str]] = {}
    for difference in ordered_differences:
        if difference.title == title:
            names.setdefault((difference.kind, difference.text), []).append(difference.name)
    return [
        difference_line(kind, list(dict.fromkeys(of_kind)), text) for (kind, text), of_kind in names.items()
    ]


def difference_line(kind: str, names: Sequence[str], text: str, shown_count: int = LINE_NAMES) -> str:
    """Return "<kind> <names>: <text>", with at most ``shown_count`` names, and the number of the others."""
    if len(names) > 1:
        kind = PLURALS.get(kind, f"{kind}s")
    return f"{' '.join(filter(None, (kind, names_text(names, shown_count))))}: {text}"
