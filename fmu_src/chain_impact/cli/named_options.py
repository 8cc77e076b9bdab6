"""Adds to an error the option whose value the error refuses; both are shown as the user typed them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from chain_impact.scene.reading import value_text
from chain_impact.simulation.record_scene import value_of

START = r"(?:^|(?<=: ))"  # where the words of a fault begin: at the start, or after the name of the scene
Change = tuple[int, int, str]
"""A change of an error's text: index of the first character to replace, index after the last, new text."""


def typed_in(words: Sequence[str], options: Iterable[str]) -> list[tuple[str, str]]:
    """Return each of the ``options`` that the ``words`` of a command have, with its value."""
    known, found = {*options}, []
    for word, following in zip(words, [*words[1:], ""], strict=True):
        option, equals, value = word.partition("=")
        if option in known:
            found.append((option, value if equals else following))
    return found


def with_option(message: str, typed: Iterable[tuple[str, str]]) -> str:
    """Return an error that tells which option has the refused value.

    The option replaces the name of the value in the error, or is put before it. The error is unchanged if it
    begins with an option, cites a line of a file, or names none of the values. An option whose name is
    already in the error does not count.

    Args:
        message: the error. What follows its first semicolon is a hint, which is not changed.
        typed: the options of the command, with their values.
    """
    fault = message.partition("; ")[0]
    if fault.startswith("-") or "(at line " in message:
        return message
    told = (pair for pair in typed if not re.search(rf"(?<!\S){pair[0]}(?![\w-])", fault))
    changes = [change for option, value in told for change in _changes(fault, option, value)]
    if not changes:
        return message
    start, end, text = min(changes)
    return f"{message[:start]}{text}{message[end:]}"


def _changes(fault: str, option: str, value: str) -> Iterator[Change]:
    """Yield each possible change that names an option in an error; ``with_option`` makes the leftmost one."""
    word, (name, equals, given) = option.lstrip("-").replace("-", "_"), value.partition("=")
    if option == "--stop-time":
        name, equals, given = "simulation.stop_time", "=", value
    if not equals:
        for pattern, part in ((rf"{word}(?: =)? {re.escape(value)}", value), *_names(value)):
            if found := re.search(rf"{START}{pattern}(?![\w*/\[]|\.\w)", fault):
                yield found.start(), found.end(), f"{option} {part}"
        return
    values = "|".join(map(re.escape, sorted(_shown(given), key=len, reverse=True)))
    whole = rf"(?<![\w.\[*])(?:{word} of )?{re.escape(name)} = (?:{values})(?![\w.])"
    if found := re.search(whole, fault):
        yield found.start(), found.end(), f"{option} {value}"
    elif found := re.search(rf"{START}{re.escape(name)}(?:\[\d+\])* = ", fault):
        yield found.start(), found.start(), f"{option} {value}: "
    elif found := re.search(rf"{START}(?:{word} of )?{re.escape(name)}(?![\w*\[]|\.\w)", fault):
        yield found.start(), found.end(), f"{option} {value}"


def _names(value: str) -> Iterator[tuple[str, str]]:
    """Yield (regular expression, name) for each name or file in a value, which commas separate.

    The expression matches this name only. Parts of the value without a letter, such as numbers, are left out.
    """
    yield from (
        (re.escape(part), part) for part in map(str.strip, value.split(",")) if re.search("[A-Za-z]", part)
    )


def _shown(given: str) -> set[str]:
    """Return all forms in which an error may show a value: as typed, as read, and as a number."""
    value = value_of(given)
    shown = {given, value_text(given), str(value), value_text(value)}
    return shown | {f"{value:g}", str(float(value))} if isinstance(value, int | float) else shown
