"""Finds the line of a scene file that has a key, and gives hints for a line that is not valid TOML."""

from __future__ import annotations

import re
from collections.abc import Sequence

from chain_impact.scene.files.text_file import comma_in
from chain_impact.scene.texts.angles import degrees_pattern
from chain_impact.scene.texts.names import DataPath
from chain_impact.scene.texts.unit_text import number_hint

LISTS_OF_TABLES = ("chain.links", "walls")
"""Lists of tables; for a table of these with the head ``[…]``, ``fault_hint`` proposes the head ``[[…]]``."""
_KEY_NAME = r"""(?:[\w-]+|"[^"]*"|'[^']*')"""
_DOTTED = rf"{_KEY_NAME}(?:\s*\.\s*{_KEY_NAME})*"
_HEAD = re.compile(rf"\s*(\[\[?)\s*({_DOTTED})\s*\]\]?")
_KEY = re.compile(rf"\s*({_DOTTED})\s*=")
_COLUMNS = re.compile(r"[^=,;\[]+([,;][^=,;]+)+")
_DEGREES = re.compile(rf"[=\[,](?:{degrees_pattern('rad')}|\s*([^\s,\"']+)\s*°)(?=[\s,\]#]|$)")


def line_of(text: str, path: DataPath) -> int | None:
    """Return the number, from 1, of the line of ``text`` that has a key.

    If no line has the key itself, the result is the line of the innermost list or table that would contain
    the key; None if no line has any of these.

    Args:
        text: a scene file.
        path: the path of the key, ``("chain", "links", 0, "mass")``.
    """
    # the best line so far: the number of entries of ``path`` that the line matches, and the number of the
    # line
    best: tuple[int, int | None] = (0, None)
    table: DataPath = ()
    counts: dict[DataPath, int] = {}
    # the quotes that began a text over several lines; "" outside of such a text, in which no keys are sought
    open_quotes = ""
    for number, line in enumerate(text.splitlines(), 1):
        if not open_quotes and (head := _HEAD.match(line)):
            table = _table_path(counts, _key_parts(head[2]))
            if head[1] == "[[":
                counts[table] = counts.get(table, -1) + 1
                table = (*table, counts[table])
            current_table = table
        elif not open_quotes and (key := _KEY.match(line)):
            current_table = (*table, *_key_parts(key[1]))
        else:
            current_table = ()
        if len(current_table) > best[0] and path[: len(current_table)] == current_table:
            best = len(current_table), number
        for quotes in ('"""', "'''"):
            if open_quotes in ("", quotes) and line.count(quotes) % 2:
                open_quotes = "" if open_quotes else quotes
    return best[1]


def _table_path(counts: dict[DataPath, int], steps: DataPath) -> DataPath:
    """Return the path of the table whose head has the keys ``steps``.

    A head has no indices. If one of its keys, except the last one, names a list, the table belongs to the
    last entry of this list so far. The path has the index of this entry, from 0, after the key. ``counts`` is
    path of each list → this index.
    """
    path: DataPath = ()
    for step in steps[:-1]:
        path = (*path, step)
        path = (*path, counts[path]) if path in counts else path
    return *path, *steps[-1:]


def _key_parts(dotted: str) -> DataPath:
    """Return the parts of a dotted key, without quotes: ("a", "b") for ``a."b"``."""
    return tuple(step.strip("\"'") for step in re.findall(_KEY_NAME, dotted))


def _keys_of_last_table(lines: Sequence[str]) -> set[DataPath]:
    """Return the keys after the last head in ``lines`` of a TOML file, as paths in the table of this head."""
    keys: set[DataPath] = set()
    for line in lines:
        if _HEAD.match(line):
            keys.clear()
        elif key := _KEY.match(line):
            keys.add(_key_parts(key[1]))
    return keys


def _other_file_hint(line: str) -> str:
    """Return a hint if the first line of a file shows a table of data or XML; "" for any other line."""
    if _COLUMNS.fullmatch(line):
        return "; it is a table of data, must be a scene: in `fit` the scene comes first, then the data"
    if line.lstrip().startswith("<"):
        return "; it is XML, must be a scene: `chain-impact convert` makes one of a robot's URDF or MJCF"
    return ""


def fault_hint(text: str, fault: str) -> str:
    """Return a hint how to correct the line of ``text`` that the TOML parser's message ``fault`` names.

    The result is "" if no hint is known.
    """
    line_match = re.search(r"at line (\d+)", fault)
    lines = text.splitlines()
    line = lines[int(line_match[1]) - 1] if line_match and int(line_match[1]) <= len(lines) else ""
    key, head = _KEY.match(line), _HEAD.match(line)
    if line_match and int(line_match[1]) == 1 and (hint := _other_file_hint(line)):
        return hint
    if "overwrite" in fault and key and line_match:
        steps, earlier_lines = _key_parts(key[1]), lines[: int(line_match[1]) - 1]
        return (
            f"; {'.'.join(map(str, steps))} is given twice"
            if steps in _keys_of_last_table(earlier_lines)
            else ""
        )
    if head:
        name = ".".join(map(str, _key_parts(head[2])))
        if name in LISTS_OF_TABLES and head[1] == "[":
            return f"; if there are several, each begins with [[{name}]]"
        return ""
    if degrees := _DEGREES.search(line):
        return f'; an angle in degrees is text: "{degrees[1] or degrees[2]} deg"'
    value = line.partition("#")[0].partition("=")[2].strip()
    quote_hint = f'; a text has quotes: "{value}"' if "Invalid value" in fault and value[:1].isalpha() else ""
    quote_hint = f"; write {value.lower()}" if value.lower() in ("true", "false") else quote_hint
    return number_hint(value) or comma_in(text, fault) or quote_hint
