"""Finds the known name that is most similar to an unknown name.

The twin in JavaScript is pages/browser/base/similar_names.js.
"""

import re
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

NUMBER = re.compile(r"\[\d*\]")
SYNONYMS = {"bounce": "restitution", "law": "model", "floor": "box"}
"""Word that a user may write after the last dot of a name → the word that is meant."""
SHORTEST_NAME = 3
"""The least number of characters of a known name that ``name_with_one_typo`` returns."""
LIKE_NAME = 0.6
"""The usual least similarity, from 0 to 1, of the unknown name and the name that ``nearest_name`` returns."""
SAME_LAST = 0.45
"""The least similarity, from 0 to 1, to the unknown name at which ``nearest_name`` returns a name with the
same part after the last dot."""
LIKE_LAST = 0.8
"""The least similarity, from 0 to 1, between an unknown name without a dot and the part of a known name after
the last dot, at which ``nearest_name`` returns the known name."""


def nearest_name(name: str, names: Iterable[str], at_least: float = LIKE_NAME) -> str | None:
    """Return the one of ``names`` that is most similar to the unknown ``name``, or None if none is similar.

    The result is from the first of these groups that contains a name:

    - the name with a synonym of the part after the last dot: ``contact.model`` for ``contact.law``
    - names that differ from ``name`` only by numbers in brackets, those with the nearest numbers first:
      ``link[1].mass`` for ``link.mass``
    - names of the same owner that contain the part after the last dot as whole words, the shortest first:
      ``joint[2].peak_force`` for ``joint[2].force``
    - if ``name`` has no dot: names whose part after the last dot has at least the similarity LIKE_LAST to
      ``name``; a name of [contact] comes first, then the shortest name: ``contact.stiffness`` for
      ``stifness``, ``link[1].length`` for ``lenght``
    - names with the same part after the last dot and at least the similarity SAME_LAST:
      ``contact[1].y_min.force`` for ``joint[1].force``
    - all names with at least the similarity ``at_least``, from 0 to 1
    """
    every, (owner, _, last) = list(names), name.rpartition(".")
    meant = f"{owner}{'.' * bool(owner)}{SYNONYMS.get(last, last)}"
    if meant != name and meant in every:
        return meant
    bare = NUMBER.sub("", name)
    numbered = [other for other in every if other != name and NUMBER.sub("", other) == bare]
    if numbered:
        numbers = _numbers(name)
        alike = [other for other in numbered if len(_numbers(other)) == len(numbers)]
        if not alike:
            return numbered[0]
        return min(
            alike, key=lambda one: sum(abs(a - b) for a, b in zip(_numbers(one), numbers, strict=True))
        )
    same = [other for other in every if owner and len(last) > 1 and other.rpartition(".")[2] == last]
    own = [other.removeprefix(f"{owner}.") for other in every if owner and other.startswith(f"{owner}.")]
    if owned := longer_name(last, own):
        return f"{owner}.{owned}"
    if not owner:
        first = sorted(every, key=lambda one: (not one.startswith("contact."), len(one)))
        by_last = {other.rpartition(".")[2]: other for other in reversed(first)}
        if alike := get_close_matches(name, by_last, n=1, cutoff=LIKE_LAST):
            return by_last[alike[0]]
    found = get_close_matches(name, every, n=1, cutoff=at_least)
    if not found or found[0] not in same:
        found = get_close_matches(name, same, n=1, cutoff=SAME_LAST) or found
    return next(iter(found), None)


def nearest_file(folder: Path, stem: str, suffix: str) -> Path | None:
    """Return the file in ``folder`` with ``suffix`` whose name without suffix is most similar to ``stem``.

    The result is None if no name is similar.
    """
    try:
        beside = {file.stem: file for file in folder.glob(f"*{suffix}")}
    except (OSError, ValueError):  # the path is too long, or no path at all
        return None
    near = nearest_name(stem, beside)
    return beside[near] if near else None


def longer_name(name: str, names: Iterable[str]) -> str | None:
    """Return the shortest of ``names`` that contains ``name`` as whole words: ``rod_drop`` for ``rod``.

    The result is None if no name contains it, or ``name`` is "".
    """
    words = re.compile(rf"(?<![^\W_]){re.escape(name)}(?![^\W_])")
    return min((known for known in names if name and words.search(known)), key=len, default=None)


def proposed_name(name: str, names: Iterable[str]) -> str | None:
    """Return the one of ``names`` that a message proposes for the unknown ``name``.

    The result is that of ``nearest_name`` or, if this is None, that of ``longer_name``, which may be None,
    too.
    """
    names = list(names)
    return nearest_name(name, names) or longer_name(name, names)


def name_with_one_typo(name: str, names: Iterable[str]) -> str | None:
    """Return the first of ``names`` that differs from ``name`` by at most one typo, or None.

    In ``name``, one character is too many, missing or wrong, or two neighbouring characters are swapped.
    Names of less than SHORTEST_NAME characters are left out.
    """
    return next((other for other in names if len(other) >= SHORTEST_NAME and _is_one_typo(name, other)), None)


def _is_one_typo(one: str, other: str) -> bool:
    pairs = enumerate(zip(one, other, strict=False))
    at = next((k for k, (a, b) in pairs if a != b), min(len(one), len(other)))
    left, right = one[at:], other[at:]
    swapped = left[1::-1] + left[2:]
    return right in (left[1:], swapped) or left == right[1:] or left[1:] == right[1:]


def _numbers(name: str) -> list[int]:
    """Return the numbers in brackets of a name: [2] for ``link[2].mass``; [0] for ``link[].mass``."""
    return [int(number[1:-1] or 0) for number in NUMBER.findall(name)]
