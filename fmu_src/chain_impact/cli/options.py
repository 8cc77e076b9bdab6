"""Arguments that several verbs have in common, and what the verbs do with them."""

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
from chain_impact.scene.similar_names import nearest, nearest_file
from chain_impact.simulation.record_scene import with_settings

if TYPE_CHECKING:
    from chain_impact.pictures.sizes import Size

    Verbs = argparse._SubParsersAction[argparse.ArgumentParser]
else:
    Verbs = object  # argparse's class is generic for type checkers only: at run time [...] is an error

Inputs = tuple[Path, str | None]
"""The file of a table of inputs, and how inputs are interpolated between its rows; None: each input has its
own default."""
OF_TABLES = ("hold", "linear", "spline")
PICTURES = (".png", ".svg", ".pdf")
SETTING = "contact.stiffness=1e9"  # the example of a setting in errors
MILLIMETRES = (51, 1500)  # the least and the largest width or height of a picture [mm]


class UsageError(ValueError):
    """Raised for an argument that cannot be used; its text is one line."""


def add_verb(verbs: Verbs, name: str, what: str, example: str) -> argparse.ArgumentParser:
    """Add a verb to the parser of the command line, and return the verb's own parser.

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
    """Add the argument ``source``: the scene, or another file that the verb accepts.

    ``what`` are the words for it in the help, such as "scene or FMU".
    """
    source = command.add_argument(
        "source",
        nargs="?",
        default=DEFAULT_SCENE,
        metavar=what.upper().replace(" OR ", "|"),
        help=f"{what}: a file, a folder with scene.toml, or a model's name; default: {DEFAULT_SCENE}",
    )
    complete_scenes(source)


def complete_scenes(argument: argparse.Action) -> None:
    """Let a shell offer models, folders, and files of scenes, FMUs and tables (see cli/completion.py)."""

    def completer(prefix: str, **_: object) -> list[str]:
        from argcomplete.completers import FilesCompleter

        files = FilesCompleter(("toml", "fmu", "csv"))(prefix)
        return [*(name for name in model_names() if name.startswith(prefix)), *files]

    # argcomplete looks for the completer of an argument in this attribute
    vars(argument)["completer"] = completer


def add_set(command: argparse.ArgumentParser) -> None:
    """Add ``--set``, and ``--stop-time`` as a short form of ``--set simulation.stop_time``."""
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
    """Add ``--inputs``, a table of inputs, and ``--interpolation``, how inputs change between its rows."""
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
    """Return the scene that the options name, with their settings and their table of inputs."""
    return scene_with(options.source, options.set, inputs_of(options))


def inputs_of(options: argparse.Namespace) -> Inputs | None:
    """Return the table of inputs that the options name, and its interpolation; None without a table."""
    if options.inputs is None and options.interpolation is not None:
        raise UsageError("--interpolation: only a table of inputs is interpolated: give --inputs FILE too")
    if options.inputs is not None and not options.inputs.exists():
        hint = near_file(options.inputs) or "must be a CSV or Parquet table"
        raise UsageError(f"--inputs {options.inputs}: there is no such file; {hint}")
    return None if options.inputs is None else (options.inputs, options.interpolation)


def near_file(missing: Any) -> str:
    """Return a hint that names the file with the name most similar to a missing one; "" if none is similar.

    The file has the same folder and the same suffix.
    """
    path = Path(str(missing))
    near = nearest_file(path.parent, path.stem, path.suffix)
    return f"the nearest is {near}" if near else ""


def scene_with(source: str, settings: Sequence[str], inputs: Inputs | None) -> Scene:
    """Return the scene ``source`` with settings ``NAME=VALUE`` and, if given, a table of inputs."""
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
    """Add an option that may be given several times; its values become a list.

    Args:
        command: the parser of the verb.
        option: the name of the option.
        metavar: the words for its value in the help.
        what: the help.
        alias: a second name of the option.
        type: function that checks and returns the text of a value.
    """
    names = [option, *([alias] if alias else [])]
    return command.add_argument(
        *names, action="append", default=[], metavar=metavar, type=type, help=f"{what}; can be repeated"
    )


class Once(argparse.Action):
    """Action of argparse for an option that may be given only once; it stores the value."""

    def __call__(self, _parser: Any, options: argparse.Namespace, value: Any, _option: Any = None) -> None:
        """Store the value of the option, or refuse a second value."""
        if getattr(options, self.dest) is not None:
            raise argparse.ArgumentError(self, "is given twice: give it once")
        setattr(options, self.dest, value)


def add_plot(command: argparse.ArgumentParser, what: str) -> None:
    """Add the options for a picture: its file, its size and its style.

    ``what`` are the words for the contents of the picture in the help.
    """
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
    """Add ``--style``, the style of a picture."""
    command.add_argument(
        "--style",
        action=Once,
        metavar="NAME",
        type=style_name,
        help="draw in a style of matplotlib, such as dark_background",
    )


def style_name(text: str) -> str:
    """Return the name of a style of matplotlib; refuse any other name."""
    from matplotlib import style  # imported here, because the import takes long

    if text not in style.available:
        near = nearest(text, style.available)
        hint = f"the nearest is {near}" if near else f"must be one of {', '.join(style.available)}"
        raise argparse.ArgumentTypeError(f"{text} is not a style of matplotlib; {hint}")
    return text


@contextmanager
def style_of(options: argparse.Namespace) -> Iterator[None]:
    """Context in which pictures are drawn in the style that the options name, if they name one."""
    name = getattr(options, "style", None)
    if name is None:
        yield
        return
    from matplotlib import style

    with style.context(name):
        yield


def figure_size(text: str) -> Size:
    """Return width and height of a picture [inches] from a text in millimetres, as 84 or 120x150.

    Without a height in the text, the height is None, and the contents of the picture determine it.
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
    """Refuse ``--size`` if no picture is written to a file, and ``--style`` if no picture is drawn at all."""
    if options.size and not options.plot:
        raise UsageError("--size: it is the size of a picture: give --plot FILE too")
    if options.style and not (options.plot or getattr(options, "show", False)):
        raise UsageError("--style: it is the style of a picture: give --plot FILE too")


def write_picture(path: Path | None, size: Size | None, plot: Callable[..., object]) -> None:
    """If ``path`` is given, draw a picture into it by ``plot(path, size=size)``, and print the path.

    Raises:
        UsageError: when the size is too small; the message gives lengths in millimetres, as ``--size`` does.
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
    """Add ``--csv``, the file of a table; it may have no suffix, as ``/dev/stdout`` has none."""
    command.add_argument("--csv", action=Once, metavar="FILE", type=ending("", ".csv"), help=f"write {what}")


def ending(*suffixes: str) -> Callable[[str], Path]:
    """Return a function by which argparse makes a path of a text, and refuses a path with another suffix.

    The suffix "" allows a path without a suffix.
    """

    def file(text: str) -> Path:
        path = Path(text)
        if path.suffix.lower() not in suffixes:
            raise argparse.ArgumentTypeError(f"{text} must end in {', '.join(filter(None, suffixes))}")
        return path

    return file


def setting(text: str) -> str:
    """Return the text of an argument ``NAME=VALUE``; refuse a text without ``=``.

    For ``--set NAME VALUE`` the shell passes VALUE as an argument of its own; if the text NAME were accepted,
    argparse would take VALUE for the scene.
    """
    if "=" not in text:
        raise argparse.ArgumentTypeError(f"{text} must be NAME=VALUE without spaces, for example {SETTING}")
    return text


def settings_of(texts: Sequence[str]) -> dict[str, str]:
    """Return the settings as name → value, from texts ``NAME=VALUE``; of equal names the last one counts."""
    return dict(name_and_value("--set", text, SETTING) for text in texts)


def name_and_value(option: str, text: str, example: str) -> tuple[str, str]:
    """Return name and value of a text ``NAME=VALUE``, the argument of ``option``.

    ``example`` is for the error.
    """
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise UsageError(f"{option} {text}: must be NAME=VALUE without spaces, for example {example}")
    return name, value


def pairs(option: str, texts: Sequence[str], example: str) -> dict[str, str]:
    """Return name → value, from texts ``NAME=VALUE`` of an option that takes each name only once."""
    values: dict[str, str] = {}
    for text in texts:
        name, value = name_and_value(option, text, example)
        if name in values:
            raise UsageError(f"{option} {text}: {name} is given twice")
        values[name] = value
    return values


def names_in(*texts: str) -> list[str]:
    """Return the names in some texts, each of which has several names, separated by commas."""
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def check_outputs(*outputs: Path | None, inputs: Iterable[str | Path]) -> None:
    """Refuse an output in a folder that does not exist, and an output that would replace an input.

    Called before any work, which would be lost if the output could not be written.
    """
    # `scene_path` returns the file of a scene, and any other path, such as that of an FMU, unchanged
    read = [path for path in map(scene_path, inputs) if path.is_file()]
    for path in filter(None, outputs):
        if not path.parent.is_dir():
            raise FileNotFoundError(ENOENT, "No such folder", str(path))
        if path.exists() and any(map(path.samefile, read)):
            raise UsageError(f"{path} is read by this command, and would be replaced; must be another file")
