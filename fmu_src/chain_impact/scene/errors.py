"""Errors and warnings on scenes, arguments and files, and their sentences."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable
from typing import Any

from chain_impact.deprecated import OlderName
from chain_impact.scene.rules.refusals import refusal_sentence
from chain_impact.scene.texts.names import DataPath, fmu_name, path_text
from chain_impact.scene.texts.similar_names import nearest_hint

NAMED_PARTS = 8  # a message lists quantities of only one owner: at most this number, then …
SHOWN_CHARACTERS = 60  # a message has at most this number of characters of a value, then ...


class RefusalError(ValueError):
    """Base of the errors on a value that a user gives: a message of parts, without names of options.

    The message is "<source>: <argument> of <name> = <value> <requirement>", without the parts that are "".

    Attributes:
        source: the name of the scene or file, with which the message begins.
        argument: the argument of the Python function that has the refused value, such as ``samples``.
        name: the name of the refused value, such as ``contact.stiffness``.
        value: the text of the refused value.
        fault: the rest of the message: "= <value>", if there is a value, and what is required.
    """

    def __init__(
        self, requirement: str, *, source: str = "", argument: str = "", name: str = "", value: str = ""
    ) -> None:
        """Store the parts of the message that are known where the fault is found; others can be set later."""
        super().__init__(requirement)
        self.source, self.argument, self.name, self.value = source, argument, name, value
        self.fault = _joined(f"= {value}", requirement) if value else requirement

    @property
    def subject(self) -> str:
        """What is refused: argument, name and value, as far as the message has them."""
        equals_text = f"= {self.value}" * bool(self.value)
        return " ".join(filter(None, [" of ".join(filter(None, [self.argument, self.name])), equals_text]))

    def message(self, subject: str | None = None) -> str:
        """Return the message; ``subject`` replaces the text ``self.subject`` in the message."""
        subject = self.subject if subject is None else subject
        requirement = self.fault.removeprefix(f"= {self.value}").lstrip() if self.value else self.fault
        return f"{self.source}: " * bool(self.source) + _joined(subject, requirement)

    def __str__(self) -> str:
        """Return the message as one line, also if names or values in the message have line breaks."""
        return " ".join(self.message().splitlines())


def _joined(subject: str, requirement: str) -> str:
    """Return both texts, with a space between them unless ``requirement`` begins with ":" or ","."""
    return subject + " " * (bool(subject) and not requirement.startswith((":", ","))) + requirement


class SceneError(RefusalError):
    """Raised when a scene, an argument or a file cannot be used.

    The message is one line. It tells, as far as they are known, the file, the key, the value and what is
    allowed.

    Attributes:
        path: the path of the key in the scene file; () if it is not known.
        line: the number of the line in the file, which the message tells after the requirement; None if it is
            not known. As ``others`` and ``meant``, it is set after the error is made.
        others: errors on other keys of the same file, with which the message ends.
        meant: the name of the key in the same table for which the unknown last key of the path probably
            stands; "" for none.
    """

    def __init__(self, requirement: str, path: DataPath = (), name: str = "", **parts: str) -> None:
        """Store the parts of the message; ``parts`` are other parts, as in the base class."""
        super().__init__(requirement, name=name, **parts)
        self.path = path
        self.line: int | None = None
        self.others: list[SceneError] = []
        self.meant = ""

    def message(self, subject: str | None = None) -> str:
        """Return the message; ``subject`` replaces the text ``self.subject`` in the message."""
        line_text = "" if self.line is None else f" (at line {self.line})"
        others_text = f"; {len(self.others)} more: {'; '.join(map(str, self.others))}" if self.others else ""
        return f"{super().message(subject)}{line_text}{others_text}"

    def __repr__(self) -> str:
        """Return the class with the whole message."""
        return f"{type(self).__name__}({str(self)!r})"

    @property
    def args(self) -> tuple[str]:  # type: ignore[override]
        """The message, as other exceptions have it."""
        return (str(self),)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return how ``pickle`` makes an equal error, with all parts, in another process."""
        return Exception.__new__, (type(self),), vars(self)

    place = OlderName("path")


def refusal(path: DataPath, fault: str, **template_values: object) -> SceneError:
    """Return the error on the key at ``path`` with the sentence on ``fault`` in refusals.py.

    ``template_values`` replace the words in braces in the sentence.
    """
    text, value = refusal_sentence(fault, **template_values), str(template_values.get("value", ""))
    begins_with_value = text.startswith(f"= {value}") and value
    return error_at(path, *((text[len(f"= {value}") :].lstrip(), value) if begins_with_value else (text,)))


def error_at(path: DataPath, requirement: str, value: str = "") -> SceneError:
    """Return the error whose name is the text of ``path``, or "scene" for ()."""
    return SceneError(requirement, path, path_text(path) or "scene", value=value)


def no_wall_error(path: DataPath, walls: Collection[str], value: str = "") -> SceneError:
    """Return the error on a key at ``path`` that names no existing wall; ``walls`` are the existing ones.

    ``value`` are the first words of the sentence, such as "= 'roof' "; "" if the key itself is the name. If
    there are no walls, the sentence has no such words.
    """
    if not walls:
        return refusal(path, "no_walls")
    return refusal(path, "no_wall", value=value, walls=", ".join(walls))


class SceneWarning(UserWarning):
    """The warning, one line, on a value or motion that is valid, but probably a mistake of the user."""


class UnknownNameError(SceneError, KeyError):
    """Raised for a name that does not exist; the message gives a hint, such as the most similar name."""

    def __init__(
        self,
        source: str,
        name: object,
        names: Iterable[str],
        what: str,
        hint: str | None = None,
        *,
        otherwise: str = "`chain-impact info SCENE` lists the names",
    ) -> None:
        """Make the message "<source>: <name> is <what>; <hint>", where ``what`` is such as "not a parameter".

        Without a hint, the message ends with the most similar of ``names``; if none is similar, with names of
        the same owner, such as ``joint[2]``; if there are none, with ``otherwise``. If ``name`` is several of
        ``names``, as "a b" or "a; b", the hint is how to separate these, whatever ``hint`` is.
        """
        names, parts = list(names), re.split(r"[\s;]+", name) if isinstance(name, str) else []
        if len(parts) > 1 and {*parts} <= {*names}:
            hint = f"it is {len(parts)} names: separate them by commas, or in Python give a list"
        if hint is None:
            other_hint = _names_of_owner(name, names) or otherwise
            hint = nearest_hint(name, names, other_hint) if isinstance(name, str) else other_hint
        text = name if isinstance(name, str) else value_text(name)
        super().__init__(f"is {what}; {hint}", name=text, source=source)


def _names_of_owner(name: object, names: Collection[str]) -> str:
    """Return a text such as "joint[2] has angle, torque" for ``joint[2].stop``; "" if no name has this owner.

    The result is also "" for a pattern such as ``*.stop``, in which ``*`` stands for all owners.
    """
    owner = str(name).rpartition(".")[0]
    owner_names = find_names(f"{owner}.*", names) if owner.strip("*") else []
    parts = list(dict.fromkeys(full_name.rpartition(".")[2] for full_name in owner_names))
    ellipsis_text = ", …" * (len(parts) > NAMED_PARTS)
    return f"{owner} has {', '.join(parts[:NAMED_PARTS])}{ellipsis_text}" if parts else ""


def names_matching(
    source: str,
    name: str,
    names: Iterable[str],
    fault: str,
    hint: Callable[[str], str | None],
) -> list[str]:
    """Return the names that ``find_names`` finds for ``name``, in which ``*`` stands for any text.

    Raises:
        UnknownNameError: when no name matches. Its hint is the text that the function ``hint`` returns for
            ``name``; if this is None, ``UnknownNameError`` finds a hint, such as the most similar name.
    """
    is_text = isinstance(name, str)
    matched = find_names(name, names) if is_text else []
    if not matched:
        raise UnknownNameError(source, name, names, fault, hint(name) if is_text else None)
    return matched


def find_names(name: str, names: Iterable[str]) -> list[str]:
    """Return ``[name]`` if ``names`` has it, or else ``[fmu_name(name)]`` if ``names`` has this.

    Otherwise return all ``names`` that match ``name``, in which ``*`` stands for any text, also for none.
    """
    for spelling in (name, fmu_name(name)):
        if spelling in names:
            return [spelling]
    if "*" not in name:
        return []
    first, *parts, last = map(re.escape, name.split("*"))
    # Of each part of ``name`` between two ``*``, only the first occurrence is tried (an atomic group),
    # because to try all combinations of occurrences would take very long for some names.
    name_pattern = re.compile("".join([first, *(f"(?>.*?{part})" for part in parts), ".*", last]))
    return [spelling for spelling in names if name_pattern.fullmatch(spelling)]


def value_text(value: Any) -> str:
    """Return the text of a value for a message: one line of at most SHOWN_CHARACTERS, and "..." if cut."""
    try:
        text = str(value).lower() if isinstance(value, bool) else " ".join(repr(value).split())
    # an integer with too many digits, or a list with too many levels, has no text
    except (ValueError, RecursionError):
        text = f"<{type(value).__name__}>"
    return text if len(text) <= SHOWN_CHARACTERS else text[:SHOWN_CHARACTERS] + "..."
