"""Arguments that several verbs have in common, and the functions that check and use their values."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from errno import ENOENT
from pathlib import Path
from typing import TYPE_CHECKING, Any

from chain_impact.cli.completers import DEFAULT_SCENE, complete, settings
from chain_impact.cli.printing import say
from chain_impact.fmu.inputs import InputTable
from chain_impact.scene.asked_inputs import with_inputs
from chain_impact.scene.errors import RefusalError
from chain_impact.scene.files.models import model_names, scene_file_path
from chain_impact.scene.scene import Scene, load_scene
from chain_impact.scene.settings import with_settings
from chain_impact.scene.texts.similar_names import nearest_file_hint, nearest_hint

if TYPE_CHECKING:
    from chain_impact.pictures.drawing.sizes import Size

    Verbs = argparse._SubParsersAction[argparse.ArgumentParser]
else:
    Verbs = object  # argparse's class is generic for type checkers only: at run time [...] is an error

TABLE_INTERPOLATIONS = ("hold", "linear", "spline")  # the choices of --interpolation for a table of inputs
PICTURES = (".png", ".svg", ".pdf")  # the suffixes of files with pictures
SETTING = "contact.stiffness=1e9"  # the example of a setting in errors
MILLIMETRES = (51, 1500)  # the least and the largest width or height of a picture [mm]


class UsageError(RefusalError):
    """Raised for an argument of the command that cannot be used; the message is one line."""


def add_verb(verbs: Verbs, name: str, help_text: str, example: str) -> argparse.ArgumentParser:
    """Add a verb to the parser of the command line, and return the verb's own parser.

    Args:
        verbs: the verbs of the command line.
        name: the verb.
        help_text: the help of the verb, which begins in lower case: "build the FMU of a scene".
        example: the arguments of an example after the verb, for the help.
    """
    return verbs.add_parser(
        name,
        help=help_text,
        description=f"{help_text[0].upper()}{help_text[1:]}.",
        epilog=f"example: chain-impact {name} {example}",
    )


def add_scene(command: argparse.ArgumentParser, help_text: str) -> None:
    """Add the argument ``source``, by default DEFAULT_SCENE: the scene, or another file that the verb takes.

    ``help_text`` are the words for this argument in the help, such as "scene or FMU".
    """
    source = command.add_argument(
        "source",
        nargs="?",
        default=DEFAULT_SCENE,
        metavar=help_text.upper().replace(" OR ", "|"),
        help=f"{help_text}: a file, a folder with scene.toml, or a model's name; default: {DEFAULT_SCENE}",
    )
    complete_scenes(source)


def complete_scenes(argument: argparse.Action) -> None:
    """Let a shell offer models, folders, and toml, fmu and csv files for an argument (completion.py)."""

    def completer(prefix: str, **_: object) -> list[str]:
        from argcomplete.completers import FilesCompleter

        files = FilesCompleter(("toml", "fmu", "csv"))(prefix)
        return [*(name for name in model_names() if name.startswith(prefix)), *files]

    # argcomplete looks for the completer of an argument in this attribute
    vars(argument)["completer"] = completer


def add_set(command: argparse.ArgumentParser) -> None:
    """Add ``--set``, and ``--stop-time`` as a short form of ``--set simulation.stop_time``."""
    help_text = "set a value by a name that `info` lists"
    complete(
        add_repeated(command, "--set", "NAME=VALUE", help_text, type=checked_setting),
        settings,
        is_valued=True,
    )
    command.add_argument(
        "--stop-time",
        action="append",
        dest="set",
        metavar="SECONDS",
        type="simulation.stop_time={}".format,
        help="end of the simulation, the same as --set simulation.stop_time=SECONDS",
    )


def add_inputs(
    command: argparse.ArgumentParser, interpolations: Sequence[str] = TABLE_INTERPOLATIONS
) -> None:
    """Add ``--inputs``, a table of inputs, and ``--interpolation``, how inputs change between its rows.

    ``interpolations`` are the choices of ``--interpolation``.
    """
    help_text = "set inputs from a table with a column time [s] and a column for each input (csv, parquet)"
    add_file(command, "--inputs", (".csv", ".parquet"), help_text)
    command.add_argument(
        "--interpolation",
        choices=interpolations,
        help="how inputs change between rows; default: spline for a base or walls that move, else hold",
    )


def load_scene_of(options: argparse.Namespace) -> Scene:
    """Return the scene ``source`` with the values of ``--set`` and the table ``--inputs``, where given."""
    return load_scene_with(options.source, options.set, input_table_of(options))


def input_table_of(options: argparse.Namespace) -> InputTable | None:
    """Return the table ``--inputs`` and its interpolation, or None without a table.

    Raises:
        UsageError: when the file does not exist, or there is an interpolation without a table.
    """
    if options.inputs is None and options.interpolation is not None:
        raise UsageError("--interpolation: only a table of inputs is interpolated: give --inputs FILE too")
    if options.inputs is not None and not options.inputs.exists():
        hint = similar_file_hint(options.inputs) or "must be a CSV or Parquet table"
        raise UsageError(f"--inputs {options.inputs}: there is no such file; {hint}")
    return None if options.inputs is None else InputTable(options.inputs, options.interpolation)


def similar_file_hint(missing_path: Any) -> str:
    """Return a hint with the file that is most similar to ``missing_path``, a file that does not exist.

    The file is in the same folder and has the same suffix. The result is "" if no name is similar.
    """
    path = Path(str(missing_path))
    return nearest_file_hint(path.parent, path.stem, path.suffix)


def load_scene_with(source: str, settings: Sequence[str], inputs: InputTable | None) -> Scene:
    """Return the scene ``source`` with ``settings``, texts NAME=VALUE, and with a table of inputs, if any."""
    scene = with_settings(load_scene(source), settings_of(settings))
    return with_inputs(scene, *inputs) if inputs else scene


def add_repeated(
    command: argparse.ArgumentParser,
    option: str,
    metavar: str,
    help_text: str,
    *,
    alias: str | None = None,
    type: Callable[[str], str] = str,
) -> argparse.Action:
    """Add an option that may be given several times, and return the option; its values are a list.

    Args:
        command: the parser of the verb.
        option: the name of the option.
        metavar: the word for a value of the option in the help.
        help_text: the help, without the words "can be repeated".
        alias: a second name of the option; None for none.
        type: function that returns the text of a value unchanged, or refuses the text.
    """
    names = [option, *([alias] if alias else [])]
    return command.add_argument(
        *names, action="append", default=[], metavar=metavar, type=type, help=f"{help_text}; can be repeated"
    )


class SingleOption(argparse.Action):
    """Action of argparse that stores the value of an option which may be given only once."""

    def __call__(self, _parser: Any, options: argparse.Namespace, value: Any, _option: Any = None) -> None:
        """Store the value of the option; refuse a second value."""
        if getattr(options, self.dest) is not None:
            raise argparse.ArgumentError(self, "is given twice: give it once")
        setattr(options, self.dest, value)


def add_plot(command: argparse.ArgumentParser, help_text: str) -> None:
    """Add the options for a picture: its file, its size and its style.

    ``help_text`` are the words for the contents of the picture in the help.
    """
    add_file(command, "--plot", PICTURES, f"draw {help_text} (png, svg, pdf)")
    command.add_argument(
        "--size",
        action=SingleOption,
        metavar="MM",
        type=parsed_figure_size,
        help="width of the picture in millimetres, as 84, or width and height, as 120x150",
    )
    add_style(command)


def add_style(command: argparse.ArgumentParser) -> None:
    """Add ``--style``, the style of a picture."""
    command.add_argument(
        "--style",
        action=SingleOption,
        metavar="NAME",
        type=style_name,
        help="draw in a style of matplotlib, such as dark_background",
    )


def style_name(text: str) -> str:
    """Return ``text`` if it is the name of a style of matplotlib; refuse any other text."""
    from matplotlib import style  # imported here, because the import takes long

    if text not in style.available:
        hint = nearest_hint(text, style.available, f"must be one of {', '.join(style.available)}")
        raise argparse.ArgumentTypeError(f"{text} is not a style of matplotlib; {hint}")
    return text


@contextmanager
def drawing_in_style(options: argparse.Namespace) -> Iterator[None]:
    """Context manager in which pictures are drawn in the style ``--style``, if it is given."""
    name = getattr(options, "style", None)
    if name is None:
        yield
        return
    from matplotlib import style

    with style.context(name):
        yield


def parsed_figure_size(text: str) -> Size:
    """Return width and height of a picture [inches] from a text with millimetres, such as 84 or 120x150.

    Without a height in the text, the height is None: then the contents of the picture determine the height.
    Other texts, and lengths out of the range MILLIMETRES, are refused.
    """
    width, cross, height = text.lower().partition("x")
    least_width, most_width = MILLIMETRES
    try:
        sides = [float(side) for side in ([width, height] if cross else [width])]
    except ValueError:
        sides = [math.nan]
    if not all(least_width <= side <= most_width for side in sides):
        raise argparse.ArgumentTypeError(
            f"{text} must be a width in millimetres, or WIDTHxHEIGHT, for example 120x150; each must be "
            f"{least_width} … {most_width}"
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
    """Draw a picture into the file ``path`` by ``plot(path, size=size)``, and print the path.

    Without a path, do nothing. ``size`` is width and height [inches]; None for the usual size.

    Raises:
        UsageError: when the size is too small; the message has lengths in millimetres, like ``--size``.
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


def add_csv(command: argparse.ArgumentParser, help_text: str) -> None:
    """Add ``--csv``, the file of a table, with the suffix .csv or without suffix, such as ``/dev/stdout``.

    ``help_text`` are the words for the contents of the table in the help.
    """
    add_file(command, "--csv", ("", ".csv"), f"write {help_text}")


def add_file(command: argparse.ArgumentParser, option: str, suffixes: Sequence[str], help_text: str) -> None:
    """Add an option for one file with one of ``suffixes`` (``path_with_suffix``)."""
    command.add_argument(
        option, action=SingleOption, metavar="FILE", type=path_with_suffix(*suffixes), help=help_text
    )


def path_with_suffix(*suffixes: str) -> Callable[[str], Path]:
    """Return a function for argparse that makes a path of a text, and refuses a path with another suffix.

    The suffix "" allows a path without suffix. Upper and lower case make no difference.
    """

    def file(text: str) -> Path:
        path = Path(text)
        if path.suffix.lower() not in suffixes:
            raise argparse.ArgumentTypeError(f"{text} must end in {', '.join(filter(None, suffixes))}")
        return path

    return file


def checked_setting(text: str) -> str:
    """Return ``text``, the value ``NAME=VALUE`` of ``--set``; refuse a text without ``=``.

    With ``--set NAME VALUE``, the text is NAME; if it were accepted, argparse would take VALUE for the scene.
    """
    if "=" not in text:
        raise argparse.ArgumentTypeError(f"{text} must be NAME=VALUE without spaces, for example {SETTING}")
    return text


def settings_of(texts: Sequence[str]) -> dict[str, str]:
    """Return name → value as text, from texts ``NAME=VALUE``; of equal names, the last one counts."""
    return dict(name_and_value("--set", text, SETTING) for text in texts)


def name_and_value(option: str, text: str, example: str) -> tuple[str, str]:
    """Return name and value of ``text``, the value ``NAME=VALUE`` of an option; refuse any other text.

    ``example`` is an example of such a text, for the error.
    """
    name, equals_sign, value = (part.strip() for part in text.partition("="))
    if not (name and equals_sign and value):
        raise UsageError(f"{option} {text}: must be NAME=VALUE without spaces, for example {example}")
    return name, value


def values_by_name(option: str, texts: Sequence[str], example: str) -> dict[str, str]:
    """Return name → value as text, from texts ``NAME=VALUE`` of an option; refuse a name that is given twice.

    ``example`` is an example of such a text, for the error.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, value = name_and_value(option, text, example)
        if name in values:
            raise UsageError(f"{option} {text}: {name} is given twice")
        values[name] = value
    return values


def names_between_commas(*texts: str) -> list[str]:
    """Return the names in all ``texts``, in each of which commas separate names."""
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def check_outputs(*outputs: Path | None, inputs: Iterable[str | Path]) -> None:
    """Refuse an output in a folder that does not exist, and an output that would replace an input.

    Verbs call this before any work, which would be lost if the output could not be written. ``inputs`` are
    names of models, scenes and other files; None among ``outputs`` is no output.
    """
    # `scene_file_path` returns the file of a scene, and any other path, such as that of an FMU, unchanged
    read_files = [path for path in map(scene_file_path, inputs) if path.is_file()]
    for path in filter(None, outputs):
        if not path.parent.is_dir():
            raise FileNotFoundError(ENOENT, "No such folder", str(path))
        if path.exists() and any(map(path.samefile, read_files)):
            raise UsageError(f"{path} is read by this command, and would be replaced; must be another file")
