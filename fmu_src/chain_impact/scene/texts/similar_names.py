"""Finds the known name that is most similar to an unknown name.

The twin in JavaScript is pages/browser/base/similar_names.js.
"""

import re
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

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
    all_names, (owner, _, last) = list(names), name.rpartition(".")
    meant_name = f"{owner}{'.' * bool(owner)}{SYNONYMS.get(last, last)}"
    if meant_name != name and meant_name in all_names:
        return meant_name
    bare_name = NUMBER.sub("", name)
    numbered_names = [
        other_name
        for other_name in all_names
        if other_name != name and NUMBER.sub("", other_name) == bare_name
    ]
    if numbered_names:
        numbers = _numbers(name)
        alike_names = [
            other_name for other_name in numbered_names if len(_numbers(other_name)) == len(numbers)
        ]
        if not alike_names:
            return numbered_names[0]
        return min(
            alike_names,
            key=lambda candidate: sum(abs(a - b) for a, b in zip(_numbers(candidate), numbers, strict=True)),
        )
    same = [
        other_name
        for other_name in all_names
        if owner and len(last) > 1 and other_name.rpartition(".")[2] == last
    ]
    owner_names = [
        other_name.removeprefix(f"{owner}.")
        for other_name in all_names
        if owner and other_name.startswith(f"{owner}.")
    ]
    if owned := longer_name(last, owner_names):
        return f"{owner}.{owned}"
    if not owner:
        first = sorted(
            all_names, key=lambda candidate: (not candidate.startswith("contact."), len(candidate))
        )
        by_last = {other_name.rpartition(".")[2]: other_name for other_name in reversed(first)}
        if alike_names := get_close_matches(name, by_last, n=1, cutoff=LIKE_LAST):
            return by_last[alike_names[0]]
    close_names = get_close_matches(name, all_names, n=1, cutoff=at_least)
    if not close_names or close_names[0] not in same:
        close_names = get_close_matches(name, same, n=1, cutoff=SAME_LAST) or close_names
    return next(iter(close_names), None)


def longer_name(name: str, names: Iterable[str]) -> str | None:
    """Return the shortest of ``names`` that contains ``name`` as whole words: ``rod_drop`` for ``rod``.

    The result is None if no name contains it, or ``name`` is "".
    """
    whole_words = re.compile(rf"(?<![^\W_]){re.escape(name)}(?![^\W_])")
    return min(
        (known_name for known_name in names if name and whole_words.search(known_name)), key=len, default=None
    )


def proposed_name(name: str, names: Iterable[str]) -> str | None:
    """Return the one of ``names`` that a message proposes for the unknown ``name``; None if none is similar.

    The result is that of ``nearest_name`` or, if this is None, that of ``longer_name``.
    """
    names = list(names)
    return nearest_name(name, names) or longer_name(name, names)


def nearest_hint(name: str, names: Iterable[str], other_hint: str = "") -> str:
    """Return the hint "the nearest is …" on the unknown ``name`` (``proposed_name``).

    The result is ``other_hint`` if none of ``names`` is similar.
    """
    near_name = proposed_name(name, names)
    return f"the nearest is {near_name}" if near_name else other_hint


def nearest_text(name: Any, names: Iterable[str]) -> str:
    """Return the end of a message on the unknown ``name``: "; the nearest is …".

    The result is "" if none of ``names`` is similar, or if ``name`` is no text.
    """
    hint = nearest_hint(name, names) if isinstance(name, str) else ""
    return f"; {hint}" if hint else ""


def nearest_file_hint(folder: Path, stem: str, suffix: str) -> str:
    """Return the hint "the nearest is …" with the file in ``folder`` whose name is most similar to ``stem``.

    Only files with ``suffix`` count; names are compared without it. The result is "" if none is similar.
    """
    try:
        stems = {file.stem: file for file in folder.glob(f"*{suffix}")}
    except (OSError, ValueError):  # the path is too long, or no path at all
        return ""
    near_stem = nearest_name(stem, stems)
    return f"the nearest is {stems[near_stem]}" if near_stem else ""


def name_with_one_typo(name: str, names: Iterable[str]) -> str | None:
    """Return the first of ``names`` that differs from ``name`` by at most one typo, or None.

    In ``name``, one character is too many, missing or wrong, or two neighbouring characters are swapped.
    Names of less than SHORTEST_NAME characters are left out.
    """
    return next(
        (
            other_name
            for other_name in names
            if len(other_name) >= SHORTEST_NAME and _is_one_typo(name, other_name)
        ),
        None,
    )


def _is_one_typo(first_name: str, second_name: str) -> bool:
    pairs = enumerate(zip(first_name, second_name, strict=False))
    difference_index = next((k for k, (a, b) in pairs if a != b), min(len(first_name), len(second_name)))
    first_rest, second_rest = first_name[difference_index:], second_name[difference_index:]
    swapped = first_rest[1::-1] + first_rest[2:]
    return (
        second_rest in (first_rest[1:], swapped)
        or first_rest == second_rest[1:]
        or first_rest[1:] == second_rest[1:]
    )


def _numbers(name: str) -> list[int]:
    """Return the numbers in brackets of a name: [2] for ``link[2].mass``; [0] for ``link[].mass``."""
    return [int(number[1:-1] or 0) for number in NUMBER.findall(name)]
