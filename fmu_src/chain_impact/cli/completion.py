"""`chain-impact completion`: what a shell needs to complete verbs, models and names of variables.

The shell asks this program at each press of the key: argcomplete finds which argument is meant, and the
functions here what it can be.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from chain_impact.cli.options import DEFAULT_SCENE, Verbs, is_fmu
from chain_impact.cli.progress import say

SHELLS = {
    "bash": "~/.bashrc",
    "zsh": "~/.zshrc",
    "fish": "~/.config/fish/config.fish",
}
"""The shells, and the files that they read when they start."""
ASKED = "_ARGCOMPLETE"  # set by a shell that asks
Completer = Callable[..., Sequence[str]]


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    completion = verbs.add_parser("completion", help="print what makes a shell complete commands and names")
    completion.add_argument(
        "shell",
        choices=list(SHELLS),
        help="bash: add to ~/.bashrc: "
        'eval "$(chain-impact completion bash)"; zsh likewise to ~/.zshrc; fish to '
        "~/.config/fish/config.fish: chain-impact completion fish | source",
    )
    completion.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print a script for the shell."""
    from argcomplete.shell_integration import shellcode

    say(shellcode(["chain-impact"], shell=options.shell))
    return 0


def answer(grammar: argparse.ArgumentParser) -> None:
    """If a shell asks for completions, give them and end the program."""
    if ASKED in os.environ:
        import argcomplete

        for command in _commands(grammar):
            for action in command._actions:
                completer = _completer(action)
                if completer:
                    vars(action)["completer"] = completer  # where argcomplete looks for it
        argcomplete.autocomplete(grammar)


def _commands(grammar: argparse.ArgumentParser) -> Iterable[argparse.ArgumentParser]:
    for action in grammar._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield from action.choices.values()


def _completer(action: argparse.Action) -> Completer | None:
    """What finds the values of an argument, by what the argument takes; None for files and numbers."""
    if not action.option_strings:
        return _scenes if action.dest == "source" else None
    lists: dict[str, Completer] = {"laws": _laws, "columns": _outputs_in_a_list}
    return {
        "NAME=VALUE": _settings,
        "NAME=VALUES": _parameters,
        "NAME=LOW:HIGH": _parameters,
        "COLUMN=SIGMA": _columns,
        "NAME": _outputs,
        "NAMES": lists.get(action.dest, _parameters_in_a_list),
        "SCENE": _scenes,
    }.get(str(action.metavar))


def _scenes(prefix: str, **_: object) -> list[str]:
    """Models, and files and folders that can be scenes."""
    from argcomplete.completers import FilesCompleter

    from chain_impact.scene.models import model_names

    files = FilesCompleter(("toml", "fmu", "csv"))(prefix)
    return [*(name for name in model_names() if name.startswith(prefix)), *files]


def _settings(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    """What ``--set`` takes: all values of a scene, or the parameters of an FMU."""
    from chain_impact.fmu.importer import read_fmu
    from chain_impact.fmu.run import EXPERIMENT
    from chain_impact.scene.scene import load_scene

    source = _source(parsed_args)
    names: list[str] = []
    with suppress(ValueError, OSError):
        if is_fmu(source):
            variables = read_fmu(Path(source)).modelVariables
            names = [*(v.name for v in variables if v.causality == "parameter"), *EXPERIMENT]
        else:
            names = list(load_scene(source).values)
    return [f"{name}=" for name in names if name.startswith(prefix)]


def _parameters(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    """Names of parameters, for a value after each."""
    return [f"{name}=" for name in _names(parsed_args, "parameter") if name.startswith(prefix)]


def _columns(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    """Names of outputs, for a value after each."""
    return [f"{name}=" for name in _names(parsed_args, "output") if name.startswith(prefix)]


def _outputs(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    return [name for name in _names(parsed_args, "output") if name.startswith(prefix)]


def _parameters_in_a_list(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    return _in_a_list(prefix, _names(parsed_args, "parameter"))


def _outputs_in_a_list(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    return _in_a_list(prefix, _names(parsed_args, "output"))


def _laws(prefix: str, **_: object) -> list[str]:
    from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS

    return _in_a_list(prefix, CONTACT_LAWS)


def _in_a_list(prefix: str, words: Iterable[str]) -> list[str]:
    """The words that can be the last one of a list with commas."""
    before = prefix[: prefix.rfind(",") + 1]
    return [before + word for word in words if word.startswith(prefix[len(before) :])]


def _names(options: argparse.Namespace, causality: str) -> list[str]:
    """The FMU variables of a scene; none if it cannot be read."""
    from chain_impact.scene.scene import load_scene
    from chain_impact.variables.model import Model

    with suppress(ValueError, OSError):
        variables = Model(load_scene(_source(options))).variables
        return [variable.name for variable in variables if variable.causality == causality]
    return []


def _source(options: argparse.Namespace) -> str:
    return str(getattr(options, "source", None) or DEFAULT_SCENE)
