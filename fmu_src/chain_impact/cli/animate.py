"""`chain-impact animate`: write an animation of a run, as a page for the browser or as a film."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

from chain_impact.cli.completers import is_fmu
from chain_impact.cli.options import (
    UsageError,
    Verbs,
    add_inputs,
    add_scene,
    add_set,
    add_style,
    add_verb,
    check_outputs,
    complete_scenes,
    input_table_of,
    load_scene_of,
    path_with_suffix,
    settings_of,
)
from chain_impact.cli.printing import say
from chain_impact.cli.progress_bar import progress
from chain_impact.cli.source import recorded_until_fault
from chain_impact.fmu.run import record_fmu
from chain_impact.recording.csv_file import NeedsSceneError, read_csv
from chain_impact.recording.pacing import IMPACT_TIME
from chain_impact.recording.recording import Recording
from chain_impact.results.animation import FILM_SIZE, FORMATS, LEAST_SIDE, MOST_SIDE, write_animation
from chain_impact.scene.scene import load_scene
from chain_impact.scene.settings import with_settings
from chain_impact.text import count_text

PAGE = FORMATS[0]  # suffix of a page for the browser; an animation with any other of FORMATS is a film


def add(verbs: Verbs) -> None:
    """Add the verb ``animate``, with its arguments and options, to the parser of the command line."""
    verb = add_verb(
        verbs,
        "animate",
        "show a scene, an FMU or a CSV file in motion, in a page or a film",
        "pinned_arm -o arm.gif",
    )
    add_scene(verb, "scene or FMU or CSV")
    add_set(verb)
    add_inputs(verb)
    verb.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=path_with_suffix(*FORMATS),
        help="write a page for the browser (html), or a film (gif, mp4); default: NAME.html",
    )
    walls = verb.add_argument("--scene", metavar="SCENE", help="for a CSV file: the scene with the walls")
    complete_scenes(walls)
    verb.add_argument(
        "--speed",
        type=float,
        help="simulated seconds in a second on the screen; default: 1; less for a fast sine in a film of at "
        "most 1500 frames",
    )
    verb.add_argument(
        "--impact-time",
        type=float,
        default=IMPACT_TIME,
        metavar="SECONDS",
        help=f"duration of an impact on the screen, 0 for no slow motion; default: {IMPACT_TIME:g}",
    )
    verb.add_argument(
        "--size",
        type=parsed_film_size,
        default=FILM_SIZE,
        metavar="WIDTHxHEIGHT",
        help=f"size of a film in pixels; default: {FILM_SIZE[0]}x{FILM_SIZE[1]}",
    )
    add_style(verb)
    verb.set_defaults(run=run)


def parsed_film_size(text: str) -> tuple[int, int]:
    """Return width and height [pixels] from a text such as 960x540; both must be LEAST_SIDE … MOST_SIDE."""
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"{text} must be WIDTHxHEIGHT, for example 960x540")
    if not all(LEAST_SIDE <= int(length) <= MOST_SIDE for length in (width, height)):
        raise argparse.ArgumentTypeError(f"{text}: width and height must be {LEAST_SIDE} … {MOST_SIDE}")
    return int(width), int(height)


def run(options: argparse.Namespace) -> int:
    """Write the animation of the source, and return the exit code.

    If a fault ends the run after its start, the animation shows the time before the fault, and then the error
    is raised.
    """
    check_outputs(options.output, inputs=filter(None, (options.source, options.scene, options.inputs)))
    if options.style and (options.output is None or options.output.suffix.lower() == PAGE):
        raise UsageError("--style: a page follows the browser, only a film has a style: give -o FILE.gif")
    recording, fault = recorded_until_fault(partial(recording_of, options))
    path = options.output or Path(f"{recording.name}.html")
    with progress("drawing") as advance:
        write_animation(
            recording,
            path,
            speed=options.speed,
            impact_time=options.impact_time,
            size=options.size,
            progress=advance,
        )
    say(f"animation  {path}, {path.stat().st_size / 1e6:.2g} MB")
    if fault:
        raise fault
    return 0


def recording_of(options: argparse.Namespace) -> Recording:
    """Return the recording of the command's source: a new run of a scene or an FMU, or the run in a CSV file.

    A scene is simulated with more rows near impacts, for slow motion. An FMU gives a row for each
    communication step, a CSV file a row for each line after the head.
    """
    from chain_impact.studies.animate import record_slowly

    settings, inputs = settings_of(options.set), input_table_of(options)
    if inputs and is_csv(options.source):
        raise UsageError(f"--inputs {inputs.file}: {options.source} is a table of a run that is over")
    if is_csv(options.source):
        return recording_of_table(Path(options.source), options.scene, settings)
    if options.scene:
        raise UsageError(f"--scene {options.scene}: only a CSV file needs it; {options.source} has its walls")
    with progress() as advance:
        if is_fmu(options.source):
            return record_fmu(Path(options.source), settings, advance, inputs)
        return record_slowly(load_scene_of(options), options.impact_time, advance)


def is_csv(source: str) -> bool:
    """Return whether the source of a command ends in .csv, in upper or lower case."""
    return source.lower().endswith(".csv")


def recording_of_table(path: Path, scene: str | None, settings: dict[str, str]) -> Recording:
    """Return the recording in a CSV file, which has outputs of a run over time.

    Args:
        path: the file.
        scene: the scene with the walls, which a CSV file does not have; None for no walls.
        settings: name → new value of parameters of this scene, as texts.

    Raises:
        UsageError: when ``scene`` is None although there are settings or the file has contacts with walls;
            or when scene and file have different numbers of links.
    """
    if scene is None:
        if settings:
            raise UsageError(
                f"--set: a CSV file has no parameters; the parameters of its walls need --scene, too: {path}"
            )
        try:
            return read_csv(path)
        except NeedsSceneError as error:
            raise UsageError(f"{error}: --scene SCENE") from None
    known_scene = with_settings(load_scene(scene), settings)
    recording = read_csv(path, known_scene)
    links, wanted_count = recording.points.shape[1] - 1, len(known_scene.chain.links)
    if links != wanted_count:
        raise UsageError(f"{path} has {count_text(links, 'link')}, and --scene {scene} has {wanted_count}")
    return recording
