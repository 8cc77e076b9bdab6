"""Arguments that several verbs have in common."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from errno import ENOENT
from pathlib import Path
from typing import TYPE_CHECKING, Any

from chain_impact.cli.completers import DEFAULT_SCENE, complete, settings
from chain_impact.cli.progress import say
from chain_impact.scene.asked_inputs import with_inputs
from chain_impact.scene.models import model_names, scene_path
from chain_impact.scene.scene import Scene, load_scene
from chain_impact.scene.similar_names import nearest
from chain_impact.simulation.record_scene import with_settings

if TYPE_CHECKING:
    from chain_impact.pictures.sizes import Size

    Verbs = argparse._SubParsersAction[argparse.ArgumentParser]
else:
    Verbs = object  # at run time argparse's class takes no type parameters, which only type checkers need

Inputs = tuple[Path, str | None]
"""The file of a table of inputs, and its interpolation; None stands for the default interpolation."""
OF_TABLES = ("hold", "linear", "spline")
PICTURES = (".png", ".svg", ".pdf")
SETTING = "contact.stiffness=1e9"  # the example in error messages about a setting
MILLIMETRES = (51, 1500)  # the least and the largest length of a side of a picture [mm]


class UsageError(ValueError):
    """Raised for an argument that cannot be used; the message is one line."""


def add_verb(verbs: Verbs, name: str, what: str, example: str) -> argparse.ArgumentParser:
    """Add a verb to the grammar, and return its parser.

    Args:
        verbs: the verbs of the command line.
        name: the verb.
        what: the help of the verb, in lower case: "build the FMU of a scene".
        example: the arguments of an example, which the help shows.
    """
    return verbs.add_parser(
        name,
        help=what,
        description=f"{what[0].upper()}{what[1:]}.",
        epilog=f"example: chain-impact {name} {example}",
    )


def add_scene(command: argparse.ArgumentParser, what: str) -> None:
    """Add the argument for the scene, or for another file that the verb accepts."""
    source = command.add_argument(
        "source",
        nargs="?",
        default=DEFAULT_SCENE,
        metavar=what.upper().replace(" OR ", "|"),
        help=f"{what}: a file, a folder with scene.toml, or a model's name; default: {DEFAULT_SCENE}",
    )
    complete_scenes(source)


def complete_scenes(argument: argparse.Action) -> None:
    """Let a shell complete models, and files and folders that may contain scenes (cli/completion.py)."""

    def completer(prefix: str, **_: object) -> list[str]:
        from argcomplete.completers import FilesCompleter

        files = FilesCompleter(("toml", "fmu", "csv"))(prefix)
        return [*(name for name in model_names() if name.startswith(prefix)), *files]

    vars(argument)["completer"] = completer  # the attribute in which argcomplete looks for the completer


def add_set(command: argparse.ArgumentParser) -> None:
    """Add ``--set``, and ``--stop-time`` as a short form for the setting of the stop time."""
    what = "set a value by a name that `info` lists"
    complete(add_repeated(command, "--set", "NAME=VALUE", what, type=setting), settings, valued=True)
    command.add_argument(
        "--stop-time",
        action="append",
        dest="set",
        metavar="SECONDS",
        type="simulation.stop_time={}".format,
        help="end of the simulation, the same as --set simulation.stop_time=SECONDS",
    )


def add_inputs(command: argparse.ArgumentParser, interpolations: Sequence[str] = OF_TABLES) -> None:
    """Add ``--inputs``, a table of inputs, and the option for the interpolation between its rows."""
    command.add_argument(
        "--inputs",
        action=Once,
        metavar="FILE",
        type=ending(".csv", ".parquet"),
        help="set inputs from a table with a column time [s] and a column for each input (csv, parquet)",
    )
    command.add_argument(
        "--interpolation",
        choices=interpolations,
        help="how inputs change between rows; default: spline for a base or walls that move, else hold",
    )


def scene_of_options(options: argparse.Namespace) -> Scene:
    """Return the scene of a command, with the settings and the inputs of its options."""
    return scene_with(options.source, options.set, inputs_of(options))


def inputs_of(options: argparse.Namespace) -> Inputs | None:
    """Return the table of inputs of a command, if there is one, and its interpolation."""
    if options.inputs is None and options.interpolation is not None:
        raise UsageError("--interpolation: only a table of inputs is interpolated: give --inputs FILE too")
    return None if options.inputs is None else (options.inputs, options.interpolation)


def scene_with(source: str, settings: Sequence[str], inputs: Inputs | None) -> Scene:
    """Return a scene with settings ``NAME=VALUE``, and with a table of inputs."""
    scene = with_settings(load_scene(source), settings_of(settings))
    return with_inputs(scene, *inputs) if inputs else scene


def add_repeated(
    command: argparse.ArgumentParser,
    option: str,
    metavar: str,
    what: str,
    *,
    alias: str | None = None,
    type: Callable[[str], str] = str,
) -> argparse.Action:
    """Add an option that can be given several times, optionally with a second name."""
    names = [option, *([alias] if alias else [])]
    return command.add_argument(
        *names, action="append", default=[], metavar=metavar, type=type, help=f"{what}; can be repeated"
    )


class Once(argparse.Action):
    """The action that stores the value of an option that can be given only once."""

    def __call__(self, _parser: Any, options: argparse.Namespace, value: Any, _option: Any = None) -> None:
        """Store the value, or refuse a second value."""
        if getattr(options, self.dest) is not None:
            raise argparse.ArgumentError(self, "is given twice: give it once")
        setattr(options, self.dest, value)


def add_plot(command: argparse.ArgumentParser, what: str) -> None:
    """Add the options for the file and the size of a picture."""
    command.add_argument(
        "--plot", action=Once, metavar="FILE", type=ending(*PICTURES), help=f"draw {what} (png, svg, pdf)"
    )
    command.add_argument(
        "--size",
        action=Once,
        metavar="MM",
        type=figure_size,
        help="width of the picture in millimetres, as 84, or width and height, as 120x150",
    )
    add_style(command)


def add_style(command: argparse.ArgumentParser) -> None:
    """Add the option for the style of a picture."""
    command.add_argument(
        "--style",
        action=Once,
        metavar="NAME",
        type=style_name,
        help="draw in a style of matplotlib, such as dark_background",
    )


def style_name(text: str) -> str:
    """Return the name of a style of matplotlib after a check."""
    from matplotlib import style  # this import takes long

    if text not in style.available:
        near = nearest(text, style.available)
        hint = f"the nearest is {near}" if near else f"must be one of {', '.join(style.available)}"
        raise argparse.ArgumentTypeError(f"{text} is not a style of matplotlib; {hint}")
    return text


@contextmanager
def style_of(options: argparse.Namespace) -> Iterator[None]:
    """In this context, draw in the style that the options of a command name, if any."""
    name = getattr(options, "style", None)
    if name is None:
        yield
        return
    from matplotlib import style

    with style.context(name):
        yield


def figure_size(text: str) -> Size:
    """Return the width and the height of a picture [inches] from a text in millimetres.

    The height is None for a text without height.
    """
    width, cross, height = text.lower().partition("x")
    least, most = MILLIMETRES
    try:
        sides = [float(side) for side in ([width, height] if cross else [width])]
    except ValueError:
        sides = [math.nan]
    if not all(least <= side <= most for side in sides):
        raise argparse.ArgumentTypeError(
            f"{text} must be a width in millimetres, or WIDTHxHEIGHT, for example 120x150; each must be "
            f"{least} … {most}"
        )
    from chain_impact.pictures import MM

    return sides[0] / MM, sides[1] / MM if cross else None


def check_look(options: argparse.Namespace) -> None:
    """Refuse the size or the style of a picture if there is no picture."""
    if options.size and not options.plot:
        raise UsageError("--size: it is the size of a picture: give --plot FILE too")
    if options.style and not (options.plot or getattr(options, "show", False)):
        raise UsageError("--style: it is the style of a picture: give --plot FILE too")


def write_picture(path: Path | None, size: Size | None, plot: Callable[..., object]) -> None:
    """Draw a picture by ``plot(path, size=size)`` if there is a file for it, and print the file's name.

    Raises:
        UsageError: when the picture has no room; the message is in millimetres, as ``--size`` is.
    """
    if not path:
        return
    from chain_impact.pictures import MM, NoRoomError

    try:
        plot(path, size=size)
    except NoRoomError as error:
        requirement = "wider" if error.least is None else f"at least {math.ceil(MM * error.least)} high"
        raise UsageError(
            f"--size: the picture has no room for its panels: it must be {requirement}"
        ) from None
    say(f"picture  {path}")


def add_csv(command: argparse.ArgumentParser, what: str) -> None:
    """Add the option ``--csv``. The file may have no suffix, for example ``/dev/stdout``."""
    command.add_argument("--csv", action=Once, metavar="FILE", type=ending("", ".csv"), help=f"write {what}")


def ending(*suffixes: str) -> Callable[[str], Path]:
    """Return a function for argparse that makes a path of a text, and refuses other suffixes than these.

    The suffix "" stands for no suffix.
    """

    def file(text: str) -> Path:
        path = Path(text)
        if path.suffix.lower() not in suffixes:
            raise argparse.ArgumentTypeError(f"{text} must end in {', '.join(filter(None, suffixes))}")
        return path

    return file


def setting(text: str) -> str:
    """Return the text of an argument ``NAME=VALUE``.

    A text without ``=`` is refused here. For ``--set NAME VALUE`` the shell passes the value as a separate
    argument, and argparse would take this value for the scene.
    """
    if "=" not in text:
        raise argparse.ArgumentTypeError(f"{text} must be NAME=VALUE without spaces, for example {SETTING}")
    return text


def settings_of(texts: Sequence[str]) -> dict[str, str]:
    """Return name → value for every ``--set NAME=VALUE``."""
    return dict(name_and_value("--set", text, SETTING) for text in texts)


def name_and_value(option: str, text: str, example: str) -> tuple[str, str]:
    """Return the two sides of one ``NAME=VALUE`` of an option."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise UsageError(f"{option} {text}: must be NAME=VALUE without spaces, for example {example}")
    return name, value


def pairs(option: str, texts: Sequence[str], example: str) -> dict[str, str]:
    """Return name → value for every ``NAME=VALUE`` of an option that takes each name once."""
    values: dict[str, str] = {}
    for text in texts:
        name, value = name_and_value(option, text, example)
        if name in values:
            raise UsageError(f"{option} {text}: {name} is given twice")
        values[name] = value
    return values


def names_in(*texts: str) -> list[str]:
    """Return the names, separated by commas, in some texts."""
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def check_outputs(*outputs: Path | None, inputs: Iterable[str | Path]) -> None:
    """Refuse an output in a missing folder, or in a file that is read; this check comes before any work."""
    # `scene_path` returns the file of a scene; for any other file, such as an FMU, it returns this file
    read = [path for path in map(scene_path, inputs) if path.is_file()]
    for path in filter(None, outputs):
        if not path.parent.is_dir():
            raise FileNotFoundError(ENOENT, "No such folder", str(path))
        if path.exists() and any(map(path.samefile, read)):
            raise UsageError(f"{path} is read by this command, and would be replaced; must be another file")
