"""Adds to an error the option whose value the error refuses, with option and value as the user typed them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from chain_impact.scene.errors import RefusalError, SceneError, value_text
from chain_impact.scene.settings import parsed_value


def typed_options(words: Sequence[str], options: Iterable[str]) -> list[tuple[str, str]]:
    """Return (option, value) for each of the ``options`` in a command: ``--size 84`` or ``--size=84``."""
    known_options, typed_pairs = {*options}, []
    for word, next_word in zip(words, [*words[1:], ""], strict=True):
        option, equals_sign, value = word.partition("=")
        if option in known_options:
            typed_pairs.append((option, value if equals_sign else next_word))
    return typed_pairs


def with_option(error: Exception, typed_pairs: Iterable[tuple[str, str]]) -> str:
    """Return the message of an error with the option whose value the error refuses.

    The option replaces the name of the value in the message, or is put before it. The message is returned
    unchanged if it tells the line of a scene file, or refuses no value of an option.

    Args:
        error: the error.
        typed_pairs: the options of the command, with their values.
    """
    message = str(error)
    if isinstance(error, SceneError) and error.line is not None:
        return message
    for option, value in typed_pairs:
        if message.startswith((f"{value}: ", f"{value} ")):  # a file
            return f"{option} {message}"
        if isinstance(error, RefusalError) and (subject := _subject(error, option, value)):
            return " ".join(error.message(subject).splitlines())
    return message


def _subject(error: RefusalError, option: str, value: str) -> str:
    """Return the text of what is refused, with ``option``; "" if the error does not refuse its ``value``."""
    argument, (name, equals_sign, given_text) = option.lstrip("-").replace("-", "_"), value.partition("=")
    if option == "--stop-time":
        name, equals_sign, given_text = "simulation.stop_time", "=", value
    if error.argument not in ("", argument):
        return ""
    if equals_sign and error.name and (error.name == name or error.name.startswith(f"{name}[")):
        is_whole = error.name == name and _is_value(error, given_text)
        return f"{option} {value}" if is_whole else f"{option} {value}: {error.subject}"
    if error.argument and not error.name:
        return f"{option} {value}"
    is_listed = not equals_sign and error.name in map(str.strip, value.split(","))
    return f"{option} {error.name}" if is_listed and error.name and not error.value else ""


def _is_value(error: RefusalError, given_text: str) -> bool:
    """Return whether the error refuses a whole value, as the user typed it, and not only a part of it."""
    if not error.value:
        return not error.fault.startswith("= ")
    value = parsed_value(given_text)
    texts = {given_text, value_text(given_text), str(value), value_text(value)}
    is_number = isinstance(value, int | float)
    return error.value in (texts | {f"{value:g}", str(float(value))} if is_number else texts)
