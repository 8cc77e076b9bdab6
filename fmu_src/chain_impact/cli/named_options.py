"""Adds to an error the option whose value the error refuses, with option and value as the user typed them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from chain_impact.scene.errors import value_text
from chain_impact.scene.settings import value_of

START = r"(?:^|(?<=: ))"  # matches where a fault begins: at the start of the error, or after ": "
Change = tuple[int, int, str]
"""A change of a text: index of the first character to replace, index after the last one, new characters."""


def typed_options(words: Sequence[str], options: Iterable[str]) -> list[tuple[str, str]]:
    """Return (option, value) for each of the ``options`` in a command: ``--size 84`` or ``--size=84``."""
    known_options, typed_pairs = {*options}, []
    for word, next_word in zip(words, [*words[1:], ""], strict=True):
        option, equals_sign, value = word.partition("=")
        if option in known_options:
            typed_pairs.append((option, value if equals_sign else next_word))
    return typed_pairs


def with_option(message: str, typed_pairs: Iterable[tuple[str, str]]) -> str:
    """Return the text of an error with the option whose value the error refuses.

    The option replaces the name of the value in the text, or is put before this name. The text is returned
    unchanged if it begins with an option, or tells the line of a file. An option is left out if the text
    already has this option, or does not name the option's value.

    Args:
        message: the text of the error. After the first semicolon follows a hint, which is not changed.
        typed_pairs: the options of the command, with their values.
    """
    fault = message.partition("; ")[0]
    if fault.startswith("-") or "(at line " in message:
        return message
    unnamed = (pair for pair in typed_pairs if not re.search(rf"(?<!\S){pair[0]}(?![\w-])", fault))
    changes = [change for option, value in unnamed for change in _changes(fault, option, value)]
    if not changes:
        return message
    start, end, text = min(changes)
    return f"{message[:start]}{text}{message[end:]}"


def _changes(fault: str, option: str, value: str) -> Iterator[Change]:
    """Yield each change by which ``fault``, an error, would name ``option``; the caller makes the leftmost.

    ``value`` is the value of the option, as the user typed it.
    """
    word, (name, equals_sign, given_text) = option.lstrip("-").replace("-", "_"), value.partition("=")
    if option == "--stop-time":
        name, equals_sign, given_text = "simulation.stop_time", "=", value
    if not equals_sign:
        for pattern, part in ((rf"{word}(?: =)? {re.escape(value)}", value), *_names(value)):
            if name_match := re.search(rf"{START}{pattern}(?![\w*/\[]|\.\w)", fault):
                yield name_match.start(), name_match.end(), f"{option} {part}"
        return
    values = "|".join(map(re.escape, sorted(_texts_of_value(given_text), key=len, reverse=True)))
    setting = rf"(?<![\w.\[*])(?:{word} of )?{re.escape(name)} = (?:{values})(?![\w.])"
    if name_match := re.search(setting, fault):
        yield name_match.start(), name_match.end(), f"{option} {value}"
    elif name_match := re.search(rf"{START}{re.escape(name)}(?:\[\d+\])* = ", fault):
        yield name_match.start(), name_match.start(), f"{option} {value}: "
    elif name_match := re.search(rf"{START}(?:{word} of )?{re.escape(name)}(?![\w*\[]|\.\w)", fault):
        yield name_match.start(), name_match.end(), f"{option} {value}"


def _names(value: str) -> Iterator[tuple[str, str]]:
    """Yield (regular expression, name) for each name in ``value``, a list of names or files with commas.

    The expression matches only the name. Parts of the value without a letter, such as numbers, are left out.
    """
    yield from (
        (re.escape(part), part) for part in map(str.strip, value.split(",")) if re.search("[A-Za-z]", part)
    )


def _texts_of_value(given_text: str) -> set[str]:
    """Return the texts by which an error may show a value: as typed, as read, and as a number."""
    value = value_of(given_text)
    shown_texts = {given_text, value_text(given_text), str(value), value_text(value)}
    return shown_texts | {f"{value:g}", str(float(value))} if isinstance(value, int | float) else shown_texts
