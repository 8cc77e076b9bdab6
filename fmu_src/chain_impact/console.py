"""The console and the screen, and the words of a command, as the system has them."""

from __future__ import annotations

import io
import os
import shlex
import subprocess
import sys

from chain_impact.system import SYSTEM, WINDOWS

LISTEN = 0.2  # [s] a program that waits checks for Ctrl-C at these intervals


def has_screen() -> bool:
    """Return whether the program can open a window.

    On Linux the result is True if the environment names a display server; on other systems it is True.
    """
    return SYSTEM != "Linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def prepare_console() -> None:
    """Let the console print a question mark for a character that its encoding lacks, instead of failing.

    By default such a character ends the program with an error. Those bytes of a file name that are no text,
    which Python by default prints unchanged in the locale POSIX, become question marks, too.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors in ("strict", "surrogateescape"):
            stream.reconfigure(errors="replace")


def quoted_word(word: str) -> str:
    """Return a word of a command in the form that the command line of this system reads as one word."""
    return subprocess.list2cmdline([word]) if SYSTEM == WINDOWS else shlex.quote(word)
