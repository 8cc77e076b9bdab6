"""The command line: build, simulate, inspect and validate."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from chain_impact.export.aot import HOST, ZIG_TARGETS, BuildError
from chain_impact.recording import Recording
from chain_impact.runs import RunError, record_fmu, record_scene
from chain_impact.scene import SceneError, load_scene, scene_to_dict
from chain_impact.simulate import SimulationError

DEFAULT_SCENE = "four_link_box"
Notify = Callable[[str], None]
out, err = Console(highlight=False), Console(stderr=True, highlight=False)


class UsageError(ValueError):
    """An argument that cannot be used; the message is one line."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return the exit code."""
    options = parser().parse_args(arguments)
    try:
        code: int = options.run(options)
    except (SceneError, SimulationError, UsageError) as error:
        err.print(f"chain-impact: {error}", markup=False, soft_wrap=True)
        return 2
    except (BuildError, RunError) as error:
        err.print(f"chain-impact: {error}", markup=False, soft_wrap=True)
        return 3
    except OSError as error:
        err.print(f"chain-impact: {error.filename}: {error.strerror}", markup=False, soft_wrap=True)
        return 2
    except KeyboardInterrupt:
        err.print("chain-impact: interrupted")
        return 130
    return code


def parser() -> argparse.ArgumentParser:
    """The grammar of the command line."""
    whole = argparse.ArgumentParser(
        prog="chain-impact", description="Impact dynamics of planar robotic chains, as an FMU."
    )
    verbs = whole.add_subparsers(required=True, metavar="COMMAND")

    build = verbs.add_parser("build", help="make the FMU of a scene")
    _add_scene(build, "scene")
    build.add_argument(
        "-o", "--output", metavar="DIR", type=Path, default=Path("build"), help="default: build"
    )
    build.add_argument(
        "--platform",
        type=_platforms,
        default=(HOST,),
        metavar="LIST",
        help=f"comma-separated, of: {', '.join(ZIG_TARGETS)}; default: {HOST}",
    )
    build.add_argument("--target", choices=["pythonfmu"], default="pythonfmu", help="kind of FMU")
    build.add_argument("--simulate", action="store_true", help="simulate it with fmpy, and draw")
    build.set_defaults(run=run_build)

    simulate = verbs.add_parser("simulate", help="simulate a scene, or an FMU with fmpy")
    _add_scene(simulate, "scene or FMU")
    simulate.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="set a parameter; can be repeated"
    )
    simulate.add_argument("--show", action="store_true", help="open a window with the picture")
    simulate.add_argument("--plot", metavar="FILE", type=Path, help="draw motion and energy (png, svg, pdf)")
    simulate.add_argument("--csv", metavar="FILE", type=Path, help="write all outputs over time")
    simulate.set_defaults(run=run_simulate)

    info = verbs.add_parser("info", help="say what a scene or an FMU holds")
    _add_scene(info, "scene or FMU")
    info.set_defaults(run=run_info)

    validate = verbs.add_parser("validate", help="check an FMU against the FMI standard")
    validate.add_argument("fmu", metavar="FMU", type=Path)
    validate.set_defaults(run=run_validate)
    return whole


def _add_scene(command: argparse.ArgumentParser, what: str) -> None:
    command.add_argument(
        "source",
        nargs="?",
        default=DEFAULT_SCENE,
        metavar=what.upper().replace(" OR ", "|"),
        help=f"{what}: a file, a folder with scene.toml, or a model's name; default: {DEFAULT_SCENE}",
    )


def _platforms(text: str) -> tuple[str, ...]:
    names = tuple(text.split(","))
    for name in names:
        if name not in ZIG_TARGETS:
            raise argparse.ArgumentTypeError(f"{name!r} is no platform; must be of {', '.join(ZIG_TARGETS)}")
    return names


# ---- the verbs ------------------------------------------------------------------------------------------


def run_build(options: argparse.Namespace) -> int:
    """Build the FMU of a scene; if asked, simulate and draw it."""
    from chain_impact.export.fmu import build_fmu

    scene = load_scene(options.source)
    with progress() as notify:
        fmu = build_fmu(scene, options.output, platforms=options.platform, notify=notify)
    out.print(f"FMU      {fmu}", markup=False, soft_wrap=True)
    if options.simulate:
        recording = record(str(fmu), [])
        csv, picture = fmu.with_suffix(".csv"), fmu.with_suffix(".png")
        recording.save_csv(csv)
        draw(recording, picture)
        out.print(f"results  {csv}\npicture  {picture}", markup=False, soft_wrap=True)
        summarize(recording)
    return 0


def run_simulate(options: argparse.Namespace) -> int:
    """Simulate a scene or an FMU; print a summary, and write what was asked for."""
    recording = record(options.source, options.set)
    if options.csv:
        recording.save_csv(options.csv)
        out.print(f"results  {options.csv}", markup=False, soft_wrap=True)
    if options.plot:
        draw(recording, options.plot)
        out.print(f"picture  {options.plot}", markup=False, soft_wrap=True)
    summarize(recording)
    if options.show:
        show(recording)
    return 0


def run_info(options: argparse.Namespace) -> int:
    """Say what a scene or an FMU holds."""
    if is_fmu(options.source):
        from fmpy import dump

        dump(options.source)
        return 0
    from chain_impact.variables import fmu_variables

    scene = load_scene(options.source)
    out.print(f"[bold]{scene.name}[/]  {scene.description}")
    for key, value in _flatten(scene_to_dict(scene)):
        if key not in {"name", "description"}:
            out.print(f"  {key} = {value}", markup=False)
    table = Table("variable", "causality", "variability", "unit", "description", box=None)
    for variable in fmu_variables(scene):
        table.add_row(
            variable.name, variable.causality, variable.variability, variable.unit, variable.description
        )
    out.print(table, markup=False)
    return 0


def run_validate(options: argparse.Namespace) -> int:
    """Check an FMU; the exit code is 1 if something is wrong."""
    from chain_impact.export.fmu import validate_fmu

    problems = validate_fmu(options.fmu)
    for problem in problems:
        out.print(problem, markup=False, soft_wrap=True)
    if not problems:
        out.print(f"{options.fmu}: no problems found", markup=False, soft_wrap=True)
    return 1 if problems else 0


# ---- what they share ------------------------------------------------------------------------------------


def is_fmu(source: str) -> bool:
    """Whether the source is meant to be an FMU."""
    return source.lower().endswith(".fmu")


def record(source: str, settings: Sequence[str]) -> Recording:
    """Simulate a scene or an FMU with parameters set by ``NAME=VALUE``."""
    values = dict(_setting(text) for text in settings)
    with progress() as notify:
        if is_fmu(source):
            return record_fmu(Path(source), values)
        return record_scene(load_scene(source), values, notify)


def _setting(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise UsageError(f"--set {text}: must be NAME=VALUE, for example contact.stiffness=1e9")
    return name.strip(), value.strip()


@contextmanager
def progress() -> Iterator[Notify]:
    """A progress bar for work of unknown length; yields a function that says what is being done."""
    columns = TextColumn("{task.description}"), BarColumn(pulse_style="cyan"), TimeElapsedColumn()
    bar = Progress(*columns, console=err, transient=True)

    def notify(sentence: str) -> None:
        if bar.task_ids:
            bar.update(bar.task_ids[0], description=sentence)
        else:
            bar.add_task(sentence, total=None)
            bar.start()

    try:
        yield notify
    finally:
        if bar.task_ids:
            bar.stop()


def draw(recording: Recording, path: Path) -> None:
    """Draw the recording into a file."""
    from chain_impact.plots import plot

    try:
        plot(recording, path)
    except ValueError as error:  # matplotlib's, for a suffix that it does not know
        raise UsageError(f"{path}: {error}") from None


def show(recording: Recording) -> None:
    """Open a window with the picture and wait until it is closed."""
    from matplotlib import pyplot

    from chain_impact.plots import fill

    fill(pyplot.figure(figsize=(12, 6), layout="constrained"), recording)
    pyplot.show()


def summarize(recording: Recording) -> None:
    """Print impacts and energy balance."""
    table = Table("#", "time, s", "point", "wall", "speed, m/s", box=None, header_style="bold")
    for number, impact in enumerate(recording.impacts, start=1):
        table.add_row(
            str(number), f"{impact.time:.6f}", str(impact.point), impact.wall, f"{impact.speed:.4f}"
        )
    out.print(f"\n[bold]{recording.name}[/]  0 … {recording.time[-1]:g} s, {len(recording.impacts)} impacts")
    out.print(table)
    total, dissipated = (recording.columns[f"energy.{name}"] for name in ("total", "dissipated"))
    supplied = recording.columns.get("energy.supplied", 0.0 * total)
    balance = total + dissipated - supplied
    parts = [f"{total[-1]:.6g} J left", f"{dissipated[-1]:.6g} J dissipated"]
    parts += [f"{-supplied[-1]:.6g} J supplied"] if supplied.any() else []
    out.print(f"energy   {total[0]:.6g} J at the start = {' + '.join(parts)}", soft_wrap=True)
    out.print(f"balance  off by at most {abs(balance - balance[0]).max():.1e} J", soft_wrap=True)


def _flatten(table: dict[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{key}.")
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for i, entry in enumerate(value, start=1):
                yield from _flatten(entry, f"{prefix}{key}[{i}].")
        else:
            yield prefix + key, value


if __name__ == "__main__":
    sys.exit(main())
