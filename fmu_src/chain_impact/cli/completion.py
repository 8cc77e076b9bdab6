"""`chain-impact completion`: print a script with which a shell completes verbs, options and models.

At each press of the Tab key the shell calls this program, and argcomplete answers.
"""

from __future__ import annotations

import argparse
import os

from chain_impact.cli.options import Verbs, add_verb
from chain_impact.cli.progress import say

SHELLS = ("bash", "zsh", "fish")
ASKED = "_ARGCOMPLETE"  # the environment variable that a shell sets when it asks for completions


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
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
    """Print a script for the shell."""
    from argcomplete.shell_integration import shellcode

    say(shellcode(["chain-impact"], shell=options.shell))
    return 0


def answer(grammar: argparse.ArgumentParser) -> None:
    """If a shell asks for completions, print these and end the program."""
    if ASKED in os.environ:
        import argcomplete

        argcomplete.autocomplete(grammar)
