"""`chain-impact completion`: print the script with which a shell completes verbs, options and models.

A shell that has run the script calls this program if the Tab key is pressed in a line that begins with
chain-impact, and the package argcomplete answers the call.
"""

from __future__ import annotations

import argparse
import os

from chain_impact.cli.options import Verbs, add_verb
from chain_impact.cli.printing import say

SHELLS = ("bash", "zsh", "fish")
# the environment variable that a shell sets when it calls the program for completions
COMPLETION_VARIABLE = "_ARGCOMPLETE"


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
    """Print the script for the shell that the user names; return the exit code."""
    from argcomplete.shell_integration import shellcode

    say(shellcode(["chain-impact"], shell=options.shell))
    return 0


def print_completions(grammar: argparse.ArgumentParser) -> None:
    """If a shell asks for completions, print these and end the program; otherwise do nothing.

    ``grammar`` is the parser of the command line.
    """
    if COMPLETION_VARIABLE in os.environ:
        import argcomplete

        argcomplete.autocomplete(grammar)
