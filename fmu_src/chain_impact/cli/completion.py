"""`chain-impact completion`: print a script by which a shell completes verbs, options and models.

At each press of the Tab key, the shell then calls this program, and the package argcomplete answers.
"""

from __future__ import annotations

import argparse
import os

from chain_impact.cli.options import Verbs, add_verb
from chain_impact.cli.progress import say

SHELLS = ("bash", "zsh", "fish")
# name of the environment variable that a shell sets if it calls the program for completions
ASKED = "_ARGCOMPLETE"


def add(verbs: Verbs) -> None:
    """Add the verb ``completion``, with its arguments and options, to the parser of the command line."""
    completion = add_verb(
        verbs,
        "completion",
        "print the script with which a shell completes commands, options, models and files",
        "bash",
    )
    completion.add_argument(
        "shell",
        choices=SHELLS,
        help="bash: add to ~/.bashrc: "
        'eval "$(chain-impact completion bash)"; zsh likewise to ~/.zshrc; fish to '
        "~/.config/fish/config.fish: chain-impact completion fish | source",
    )
    completion.set_defaults(run=run, only_prints=True)


def run(options: argparse.Namespace) -> int:
    """Print the script for a shell."""
    from argcomplete.shell_integration import shellcode

    say(shellcode(["chain-impact"], shell=options.shell))
    return 0


def answer(grammar: argparse.ArgumentParser) -> None:
    """If a shell asks for completions, print them and end the program; otherwise do nothing."""
    if ASKED in os.environ:
        import argcomplete

        argcomplete.autocomplete(grammar)
