"""The command line: its parser, and the errors and exit codes of its verbs.

Each verb is a module with two functions: ``add`` adds the verb to the parser, ``run`` executes it.
"""

from __future__ import annotations

import argparse
import re
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from errno import EACCES, EDQUOT, ENOENT, ENOSPC, EPERM, EROFS
from importlib import import_module
from importlib.metadata import version
from types import MappingProxyType
from typing import Any, NoReturn

from chain_impact.cli import completion
from chain_impact.cli.options import UsageError, drawing_in_style, similar_file_hint
from chain_impact.cli.options_in_errors import typed_options, with_option
from chain_impact.cli.printing import complain, out, say
from chain_impact.compilation.errors import BuildError
from chain_impact.console import prepare_console
from chain_impact.extras import MissingExtraError
from chain_impact.scene.errors import RefusalError, SceneWarning
from chain_impact.scene.texts.similar_names import nearest_text, proposed_name
from chain_impact.simulation.errors import RunError

REMEDIES = dict.fromkeys((ENOSPC, EDQUOT), "free some space, or write to another disk") | dict.fromkeys(
    (EROFS, EACCES, EPERM), "ask for the right to use it, or choose another place"
)
"""Number of an error of the operating system on a file → advice for the user."""
FIRST_STEPS = """chain-impact simulates planar chains that hit walls. First steps:

  chain-impact simulate pinned_arm --plot arm.png   simulate a model: impacts, peak forces, a picture
  chain-impact explore pinned_arm                   change it by hand in the browser
  chain-impact build pinned_arm                     make its FMU

All commands: chain-impact --help. All models: chain-impact info --list models."""
VERBS = tuple(
    import_module(f"chain_impact.cli.{name}")
    for name in (
        "build",
        "simulate",
        "animate",
        "explore",
        "compare",
        "sweep",
        "fit",
        "convert",
        "info",
        "validate",
        "cache",
        "completion",
    )
)
"""The modules of the verbs, in the order of the help."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Execute the command with the words ``arguments``, by default the arguments of the process.

    Return the exit code: 0; 1 for faults of FMUs that ``validate`` finds; 2 for a wrong argument, scene or
    file, no verb, or a missing package; 3 for a fault of a run or a build; 130 after Ctrl-C. After an error
    of the parser, also code 2, and after --help or --version, SystemExit is raised instead.
    """
    prepare_console()
    grammar = parser()
    completion.print_completions(grammar)
    options = grammar.parse_args(arguments)
    if options.run is None:
        say(FIRST_STEPS)
        return 2
    out.quiet = options.quiet and not options.only_prints
    typed_names = typed_options(sys.argv[1:] if arguments is None else arguments, options.valued)
    try:
        with show_hints(), drawing_in_style(options):
            code: int = options.run(options)
    except (RefusalError, BuildError, RunError) as error:
        complain(with_option(error, typed_names))
        return 3 if isinstance(error, BuildError | RunError) else 2
    except ImportError as error:
        is_damaged = not isinstance(error, MissingExtraError)
        complain(f"a package is damaged, install it anew: {error}" if is_damaged else error)
        return 2
    except OSError as error:
        fault = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        remedy = (
            similar_file_hint(error.filename) if error.errno == ENOENT else REMEDIES.get(error.errno or 0)
        )
        complain(with_option(UsageError(f"{fault}; {remedy}" if remedy else fault), typed_names))
        return 2
    except KeyboardInterrupt:
        complain("interrupted")
        return 130
    return code


@contextmanager
def show_hints() -> Iterator[None]:
    """Context manager in which a warning is printed as one line, and equal warnings only once.

    Python's own print of a warning would add the file, the line number and the line of code. With
    ``--quiet``, no warning is printed.
    """
    shown_hints = set()

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        if not out.quiet and str(message) not in shown_hints:
            shown_hints.add(str(message))
            complain(f"warning: {message}")

    with warnings.catch_warnings():
        warnings.simplefilter("always", SceneWarning)
        warnings.showwarning = show
        yield


class Parser(argparse.ArgumentParser):
    """A parser that reports an error in one line, with a hint on what may be meant.

    ``verbs_by_option`` is option → the names of all verbs that have this option.
    """

    verbs_by_option: Mapping[str, Sequence[str]] = MappingProxyType({})

    def error(self, message: str) -> NoReturn:
        """Print the error ``message`` as one line, without the usage of the command, and exit with code 2."""
        for kind, needed_text in (("int", "a whole number"), ("float", "a number")):
            message = re.sub(rf"invalid {kind} value: '(.*)'$", rf"\1 must be {needed_text}", message)
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse the arguments, and refuse those that this parser does not have.

        The parser of a verb refuses them itself, because it can name the most similar option of the verb.
        argparse would leave this to the main parser, which does not know the options of verbs.
        """
        options, other_arguments = super().parse_known_args(args, namespace)
        if other_arguments:
            self.error(self._fault_of(other_arguments[0]))
        return options, other_arguments

    def _fault_of(self, argument: str) -> str:
        """Return the message on an argument that the verb does not have, with a hint if there is one."""
        if not argument.startswith("-"):
            is_setting = "=" in argument and "--set" in self._option_string_actions
            return f"{argument} is one argument too many" + (
                f"; write --set {argument}" if is_setting else ""
            )
        option = argument.partition("=")[0]
        files = [action for action in self._actions if action.metavar == "FILE"]
        output_options = [
            file.option_strings[0] for file in files if str(file.help).startswith(("write", "draw"))
        ]
        if option.startswith("-o") and output_options:
            return f"{option} is not an option; files are written by {', '.join(output_options)}"
        # names are compared without dashes, because dashes would make all short names similar
        long_names = [name[2:] for name in self._option_string_actions if name.startswith("--")]
        verbs_text = ", ".join(self.verbs_by_option.get(option, ()))
        near_option = proposed_name(option.strip("-"), long_names)
        near_text = f"; the nearest is --{near_option}" if near_option else ""
        return f"{option} is not an option" + (f"; it belongs to {verbs_text}" if verbs_text else near_text)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is not among the choices of an argument.

        The error names the most similar choice, if any choice is similar. The error lists all choices, except
        for an unknown verb.
        """
        if action.choices is None or value in action.choices:
            return
        choices_text = f"must be one of {', '.join(map(str, action.choices))}"
        fault = "is not a command" if isinstance(action.choices, dict) else choices_text
        near_text = nearest_text(str(value), map(str, action.choices))
        raise argparse.ArgumentError(action, f"{value} {fault}{near_text}")


def parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command line, with VERBS."""
    purpose_text = "Simulate planar chains that hit walls, study their impacts, and make FMUs of them."
    main_parser = Parser(prog="chain-impact", description=purpose_text)
    main_parser.set_defaults(run=None, only_prints=False, valued=())
    main_parser.add_argument("--version", action="version", version=f"chain-impact {version('chain-impact')}")
    verbs = main_parser.add_subparsers(metavar="COMMAND")
    for verb in VERBS:
        verb.add(verbs)
    for command in verbs.choices.values():
        quiet_text = argparse.SUPPRESS if command.get_default("only_prints") else "print nothing but errors"
        free_actions = (
            action for action in command._actions if action.nargs is None and action.choices is None
        )
        command.set_defaults(valued=[name for action in free_actions for name in action.option_strings])
        command.add_argument("-q", "--quiet", action="store_true", help=quiet_text)
    verbs_of_options: dict[str, list[str]] = {}
    for name, command in verbs.choices.items():
        command.verbs_by_option = verbs_of_options
        for option in command._option_string_actions:
            verbs_of_options.setdefault(option, []).append(name)
    return main_parser
