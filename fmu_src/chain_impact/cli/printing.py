"""Prints the texts of the command line on standard output and standard error."""

from __future__ import annotations

from functools import partial

from rich.console import Console

plain_console = partial(Console, highlight=False, markup=False, emoji=False)
"""Make a console of rich that prints each text unchanged, also with [brackets] and :names:."""
out, err = plain_console(), plain_console(stderr=True)
"""The consoles of standard output and of standard error."""


def say(text: str) -> None:
    """Print a text on standard output, unchanged."""
    out.print(text, soft_wrap=True)


def complain(text: object) -> None:
    """Print "chain-impact: " and an error, a warning or a message on standard error."""
    err.print(f"chain-impact: {text}", soft_wrap=True)
