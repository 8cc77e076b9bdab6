"""The command line: build, simulate, compare, inspect and validate."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from errno import ENOENT
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from rich.console import RenderableType
from rich.markup import escape

from chain_impact.compilation import cache, ready
from chain_impact.compilation.compilers import HOST, ZIG_TARGETS
from chain_impact.compilation.errors import BuildError
from chain_impact.progress import err, out, progress
from chain_impact.reading import SceneError
from chain_impact.recording import Recording
from chain_impact.runs import RunError, read_fmu, record_fmu, record_scene, with_settings
from chain_impact.scene import load_scene, scene_to_dict
from chain_impact.screen import cache_report, law_table, summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEFAULT_SCENE = "four_link_box"
PICTURES = (".png", ".svg", ".pdf")


class UsageError(ValueError):
    """An argument that cannot be used; the message is one line."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return the exit code."""
    options = parser().parse_args(arguments)
    try:
        code: int = options.run(options)
    except (SceneError, UsageError) as error:
        err.print(f"chain-impact: {error}", markup=False, soft_wrap=True)
        return 2
    except (BuildError, RunError) as error:
        err.print(f"chain-impact: {error}", markup=False, soft_wrap=True)
        return 3
    except OSError as error:
        what = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        err.print(f"chain-impact: {what}", markup=False, soft_wrap=True)
        return 2
    except KeyboardInterrupt:
        err.print("chain-impact: interrupted")
        return 130
    return code


class Parser(argparse.ArgumentParser):
    """Says in one line what is wrong."""

    def error(self, message: str) -> NoReturn:
        """Leave out the usage."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser() -> argparse.ArgumentParser:
    """The grammar of the command line."""
    whole = Parser(prog="chain-impact", description="Impact dynamics of planar robotic chains, as an FMU.")
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
        help=f"comma-separated, of: {', '.join(ZIG_TARGETS)}; or all; default: {HOST}",
    )
    build.add_argument(
        "--target",
        choices=["pythonfmu", "native"],
        default="pythonfmu",
        help="native: an FMU that needs no Python; default: pythonfmu",
    )
    build.add_argument("--simulate", action="store_true", help="simulate it with fmpy, and draw")
    build.set_defaults(run=run_build)

    simulate = verbs.add_parser("simulate", help="simulate a scene, or an FMU with fmpy")
    _add_scene(simulate, "scene or FMU")
    _add_set(simulate)
    simulate.add_argument("--show", action="store_true", help="open a window with the picture")
    simulate.add_argument(
        "--plot", metavar="FILE", type=_picture, help="draw motion, energy and impacts (png, svg, pdf)"
    )
    simulate.add_argument("--csv", metavar="FILE", type=Path, help="write the outputs over time")
    simulate.set_defaults(run=run_simulate)

    compare = verbs.add_parser("compare", help="simulate a scene with every contact law, side by side")
    _add_scene(compare, "scene")
    _add_set(compare)
    compare.add_argument(
        "--plot",
        metavar="FILE",
        type=_picture,
        help="draw restitution, first impact and energy (png, svg, pdf)",
    )
    compare.add_argument("--csv", metavar="FILE", type=Path, help="write the table")
    compare.set_defaults(run=run_compare)

    info = verbs.add_parser("info", help="say what a scene or an FMU holds")
    _add_scene(info, "scene or FMU")
    info.set_defaults(run=run_info)

    validate = verbs.add_parser("validate", help="check an FMU against the FMI standard")
    validate.add_argument("fmu", metavar="FMU", type=Path)
    validate.set_defaults(run=run_validate)

    kept = verbs.add_parser("cache", help="say which compiled kernels there are, and where; or remove them")
    kept.add_argument("--clear", action="store_true", help="remove all that is in the cache")
    kept.set_defaults(run=run_cache)
    return whole


def _add_scene(command: argparse.ArgumentParser, what: str) -> None:
    command.add_argument(
        "source",
        nargs="?",
        default=DEFAULT_SCENE,
        metavar=what.upper().replace(" OR ", "|"),
        help=f"{what}: a file, a folder with scene.toml, or a model's name; default: {DEFAULT_SCENE}",
    )


def _add_set(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="set a parameter; can be repeated"
    )


def _platforms(text: str) -> tuple[str, ...]:
    names = tuple(text.split(","))
    for name in names:
        if name not in ZIG_TARGETS and text != "all":
            known = ", ".join(ZIG_TARGETS)
            raise argparse.ArgumentTypeError(f"{name!r} is no platform; must be of {known}, or all")
    return names


def _picture(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in PICTURES:
        raise argparse.ArgumentTypeError(f"{text} must end in {', '.join(PICTURES)}")
    return path


# ---- the verbs ------------------------------------------------------------------------------------------


def run_build(options: argparse.Namespace) -> int:
    """Build the FMU of a scene; if asked, simulate and draw it."""
    from chain_impact.export.fmu import build_fmu

    scene = load_scene(options.source)
    with progress() as (notify, _):
        fmu = build_fmu(
            scene, options.output, target=options.target, platforms=options.platform, notify=notify
        )
    out.print(f"FMU      {fmu}", markup=False, soft_wrap=True)
    if options.simulate:
        report(str(fmu), [], fmu.with_suffix(".csv"), fmu.with_suffix(".png"))
    return 0


def run_simulate(options: argparse.Namespace) -> int:
    """Simulate a scene or an FMU; print a summary, and write what was asked for."""
    window = open_window() if options.show else None
    recording = report(options.source, options.set, options.csv, options.plot)
    if window:
        from matplotlib import pyplot

        from chain_impact.plots import fill

        fill(window, recording)
        pyplot.show()
    return 0


def run_compare(options: argparse.Namespace) -> int:
    """Simulate a scene with every law; print the table and the advice, and write what was asked for."""
    from chain_impact.compare import compare

    check_folders(options.csv, options.plot)
    scene = with_settings(load_scene(options.source), dict(_setting(text) for text in options.set))
    with progress("comparing") as (notify, advance):
        comparison = compare(scene, notify, advance)
    if options.csv:
        comparison.save_csv(options.csv)
        out.print(f"table    {options.csv}", markup=False, soft_wrap=True)
    if options.plot:
        from chain_impact.compare_plot import plot_comparison

        with progress("drawing") as (notify, advance):
            plot_comparison(comparison, options.plot, notify, advance)
        out.print(f"picture  {options.plot}", markup=False, soft_wrap=True)
    show(law_table(comparison))
    return 0


def run_info(options: argparse.Namespace) -> int:
    """Say what a scene or an FMU holds."""
    facts: list[tuple[str, object]] = []
    if is_fmu(options.source):
        from fmpy import supported_platforms

        held = read_fmu(Path(options.source))
        name, description, variables = held.modelName, held.description or "", held.modelVariables
        facts += [("FMI version", held.fmiVersion), ("made by", held.generationTool), ("guid", held.guid)]
        facts += [("platforms", ", ".join(supported_platforms(options.source)))]
        if held.defaultExperiment:
            facts += [(key, getattr(held.defaultExperiment, key)) for key in ("stopTime", "stepSize")]
        facts += [(v.name, v.start) for v in variables if v.causality == "parameter"]
    else:
        from chain_impact.variables import fmu_variables

        scene = load_scene(options.source)
        name, description, variables = scene.name, scene.description, fmu_variables(scene)
        facts += [pair for pair in _flatten(scene_to_dict(scene)) if pair[0] not in {"name", "description"}]
    out.print(f"[bold]{escape(name)}[/]  {escape(description)}", soft_wrap=True)
    for key, value in facts:
        out.print(f"  {key} = {value}", markup=False, soft_wrap=True)
    out.print("\n[bold]Variables of the FMU[/]")
    rows = [(v.name, v.causality, v.variability, v.unit or "", v.description or "") for v in variables]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        out.print(f"  {'  '.join(cells).rstrip()}", markup=False, soft_wrap=True)
    return 0


def run_validate(options: argparse.Namespace) -> int:
    """Check an FMU; the exit code is 1 if something is wrong."""
    from chain_impact.export.fmu import validate_fmu

    options.fmu.stat()  # a file that is not there is no FMU with problems
    problems = validate_fmu(options.fmu)
    for problem in problems:
        out.print(f"{options.fmu}: {problem}", markup=False, soft_wrap=True)
    if not problems:
        out.print(f"{options.fmu}: no problems found", markup=False, soft_wrap=True)
    return 1 if problems else 0


def run_cache(options: argparse.Namespace) -> int:
    """Say what is in the cache of compiled kernels, or remove it."""
    if options.clear:
        size = cache.clear()
        out.print(f"removed {size / 1e6:.1f} MB from {cache.base_folder()}", markup=False, soft_wrap=True)
        return 0
    for line in cache_report(ready.libraries(), cache.entries(), cache.cache_folder()):
        out.print(line, markup=False, soft_wrap=True)
    return 0


# ---- what they share ------------------------------------------------------------------------------------


def is_fmu(source: str) -> bool:
    """Whether the source is meant to be an FMU."""
    return source.lower().endswith(".fmu")


def record(source: str, settings: Sequence[str]) -> Recording:
    """Simulate a scene or an FMU with parameters set by ``NAME=VALUE``."""
    values = dict(_setting(text) for text in settings)
    with progress() as (notify, advance):
        if is_fmu(source):
            return record_fmu(Path(source), values, advance)
        return record_scene(load_scene(source), values, notify, advance)


def _setting(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise UsageError(f"--set {text}: must be NAME=VALUE, for example contact.stiffness=1e9")
    return name.strip(), value.strip()


def report(source: str, settings: Sequence[str], csv: Path | None, picture: Path | None) -> Recording:
    """Simulate, write the files asked for and print a summary; also of what came before a fault."""
    check_folders(csv, picture)
    fault = None
    try:
        recording = record(source, settings)
    except RunError as error:
        if error.recording is None:
            raise
        recording, fault = error.recording, error
    if csv:
        recording.save_csv(csv)
        out.print(f"results  {csv}", markup=False, soft_wrap=True)
    if picture:
        from chain_impact.plots import plot

        plot(recording, picture)
        out.print(f"picture  {picture}", markup=False, soft_wrap=True)
    show(summary(recording))
    if fault:
        raise fault
    return recording


def check_folders(*paths: Path | None) -> None:
    """Refuse files in folders that are not there, before any work is done."""
    for path in paths:
        if path and not path.parent.is_dir():
            raise FileNotFoundError(ENOENT, "No such folder", str(path))


def open_window() -> Figure:
    """An empty page in a window."""
    from matplotlib import pyplot

    try:
        page = pyplot.figure(figsize=(12, 6.5), layout="constrained")
    except ImportError as error:  # a backend asked for by MPLBACKEND
        raise RunError(f"--show: {error}") from None
    if page.canvas.required_interactive_framework is None:
        raise RunError("--show: there is no display, or no window toolkit for matplotlib; use --plot FILE")
    return page


def show(parts: Iterable[RenderableType]) -> None:
    """Print one after the other, whole lines however narrow the terminal."""
    for part in parts:
        out.print(part, soft_wrap=True)


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
