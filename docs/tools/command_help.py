"""The help of every command, for a page of the docs; argparse's own layout differs between Pythons."""

from __future__ import annotations

import textwrap
from argparse import Action, ArgumentParser, _SubParsersAction
from collections.abc import Iterator

from chain_impact import cli

REPEATED = "; can be repeated"  # these words are left out: the page lists once the options that have them
WIDTH, SECOND = 88, 24  # number of characters in a line; number of those before the second column
SHARED = {"help", "quiet", "source", "set"}  # arguments of several commands, which the page explains itself


def command_line() -> str:
    """Return the help of every command."""
    parser = cli.parser()
    verbs = next(action.choices for action in parser._actions if isinstance(action.choices, dict))
    having: dict[str, list[str]] = {}  # rows of an argument or option → the commands with this row
    for name, verb in verbs.items():
        for rows in _all_rows(verb):
            having.setdefault(rows, []).append(name)
    shared_rows: dict[str, list[str]] = {}  # commands → the rows of their common options
    for rows, names in having.items():
        if len(names) > 1:
            shared_rows.setdefault(", ".join(names), []).append(rows)
    common = "\n".join("\n".join([f"{names}:", *rows]) for names, rows in shared_rows.items())
    blocks = [
        _block(_usage(parser), *_all_rows(parser)),
        f"## Options of several commands\n\n{_block(common)}",
    ]
    for name, verb in verbs.items():
        own_rows = [rows for rows in _all_rows(verb) if len(having[rows]) == 1]
        blocks.append(f"## {name}\n\n{_block(_usage(verb), *own_rows)}")
    return "\n\n".join(blocks)


def _block(*lines: str) -> str:
    return "\n".join(["```text", *lines, "```"])


def _all_rows(parser: ArgumentParser) -> list[str]:
    """Return the rows of each argument and option that is not in SHARED."""
    actions = [action for action in parser._actions if action.dest not in SHARED]
    return [rows for action in actions if (rows := "\n".join(_rows(parser, action)))]


def _usage(parser: ArgumentParser) -> str:
    """Return the usage as one line with all arguments, and with those options that are required."""
    parts = [parser.prog, "[options]"]
    for action in parser._actions:
        name = action.metavar or action.dest.upper()
        if action.option_strings and action.required:
            parts.append(f"{action.option_strings[0]} {name}")
        elif not action.option_strings:
            forms = {"?": f"[{name}]", "+": f"{name} [{name} ...]", "A...": f"{name} ..."}
            parts.append(forms.get(str(action.nargs), str(name)))
    return " ".join(parts)


def _rows(parser: ArgumentParser, action: Action) -> Iterator[str]:
    """Yield the text of an argument or option in two columns; for the list of commands, a line for each."""
    if isinstance(action, _SubParsersAction):
        for verb in action._get_subactions():
            yield f"  {verb.dest}".ljust(SECOND) + str(verb.help)
        return
    if not action.help:
        return
    choices = "{" + ",".join(map(str, action.choices)) + "}" if action.choices else ""
    value = [] if action.nargs == 0 else [str(action.metavar or choices or action.dest.upper())]
    head = "  " + " ".join([", ".join(action.option_strings), *value]).strip()
    text = parser._get_formatter()._expand_help(action).removesuffix(REPEATED)
    line_break = "\n" + " " * SECOND
    lines = line_break.join(textwrap.wrap(text, WIDTH - SECOND, break_on_hyphens=False))
    yield (head + line_break + lines if len(head) + 2 > SECOND else head.ljust(SECOND) + lines).rstrip()
