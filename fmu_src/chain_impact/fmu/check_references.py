"""The reference results that an FMU carries, held against a simulation of it, whoever has made it.

Read are the manifest of FMI-LS-REF, files of experiments as MA-HS-Experiments describes them, and tables of
results without an experiment, as the Reference-FMUs have them: those of the default experiment. Both formats
are named in ``chain_impact.fmu.references``.
"""

from __future__ import annotations

import csv
import io
import math
import posixpath
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from chain_impact.fmu.importer import read_fmu, simulated
from chain_impact.fmu.references import MANIFEST, TOLERANCES
from chain_impact.fmu.run import platforms_of
from chain_impact.scene.reading import SceneError
from chain_impact.simulation.record_scene import RunError
from chain_impact.system import HOST

SHARE = 1e-3  # of the range of an output, tolerated where the FMU does not state its tolerance
TABLE = "text/csv"


class UncheckedError(Exception):
    """What makes it impossible to compare, in words; ``wrong`` if that is the FMU's fault."""

    def __init__(self, reason: str, wrong: bool = True) -> None:
        """Keep whose fault it is."""
        super().__init__(reason)
        self.wrong = wrong


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came out of one experiment.

    Attributes:
        text: a line that says what.
        passed: False if the FMU gives something else than it says, or says it in a wrong way.
    """

    text: str
    passed: bool


@dataclass(frozen=True, slots=True)
class Experiment:
    """What an FMU says that it does.

    Attributes:
        settings: start, stop and step [s], as far as they are stated.
        results: columns of what comes out, ``time`` among them.
        tolerances: name of an output → how far it may be off.
        stimuli: columns of the inputs, ``time`` among them, if any.
        shared: whether the results are a table that FMUs with other variables have, too.
    """

    settings: Mapping[str, float]
    results: Mapping[str, np.ndarray]
    tolerances: Mapping[str, float]
    stimuli: Mapping[str, np.ndarray] | None = None
    shared: bool = False


def check_references(path: Path) -> list[Outcome]:
    """Simulate every experiment of an FMU with fmpy and compare; none if it has no reference results.

    Raises:
        SceneError: when the file is no FMU.
    """
    description = read_fmu(path)
    with zipfile.ZipFile(path) as fmu:
        files = {name: fmu.read(name) for name in fmu.namelist() if name.startswith("extra/")}
    if MANIFEST not in files:
        return []
    outcomes = []
    for label, read in _experiments(files):
        try:
            outcomes.append(Outcome(f"{label}: {_checked(path, description, read())}", True))
        except UncheckedError as error:
            outcomes.append(Outcome(f"{label}: {error}", not error.wrong))
        except (SceneError, RunError) as error:
            outcomes.append(Outcome(f"{label}: cannot be simulated: {error}", False))
    return outcomes


# --- reading ---------------------------------------------------------------------------------------------


def _experiments(files: Mapping[str, bytes]) -> Iterator[tuple[str, Callable[[], Any]]]:
    """What to call each experiment, and a function that reads it, or fails to."""
    try:
        manifest = _parsed(files, MANIFEST)
    except UncheckedError:
        yield MANIFEST, partial(_parsed, files, MANIFEST)
        return
    related = [(e.get("role", ""), _place(MANIFEST, e)) for e in manifest.iter("Related")]
    compared = set()
    for source in (source for role, source in related if role.partition("/")[0] == "experiment"):
        try:
            nodes = list(_parsed(files, source).iter("Experiment"))
        except UncheckedError:
            yield source, partial(_parsed, files, source)
            continue
        for node in nodes:
            compared |= {_place(source, results) for results in node.iter("References")}
            yield f"experiment {node.get('name', '')}", partial(_experiment, files, source, node)
    for role, source in related:
        if role == "result" and source not in compared:
            yield f"results {posixpath.basename(source)}", partial(_default_experiment, files, source)


def _default_experiment(files: Mapping[str, bytes], table: str) -> Experiment:
    return Experiment({}, _columns(files, table), {}, shared=True)


def _experiment(files: Mapping[str, bytes], file: str, node: Element) -> Experiment:
    if node.find("Parameters") is not None:
        raise UncheckedError("not run: sets of parameters are not supported", wrong=False)
    results, stimuli = node.find("References"), node.find("Stimuli")
    if results is None:
        raise UncheckedError("not run: it has no reference results", wrong=False)
    # the published draft has the times as attributes of the experiment, a later schema in an element
    times = {**node.attrib, **getattr(node.find("TransientSimulation"), "attrib", {})}
    names = ("startTime", "stopTime", "stepSize")
    return Experiment(
        settings={name: _number(times[name], f"{file}: {name}") for name in names if name in times},
        results=_time_series(files, file, results),
        tolerances={
            entry.get("name", ""): _number(entry.get("absolute", ""), f"{file}: a tolerance")
            for annotation in results.iter("Annotation")
            if annotation.get("type") == TOLERANCES
            for entry in annotation
        },
        stimuli=None if stimuli is None else _time_series(files, file, stimuli),
    )


def _time_series(files: Mapping[str, bytes], file: str, node: Element) -> dict[str, np.ndarray]:
    kind = node.get("type", TABLE)
    if kind != TABLE:
        raise UncheckedError(f"not run: {kind} is not supported", wrong=False)
    return _columns(files, _place(file, node))


def _place(file: str, node: Element) -> str:
    """The name in the FMU of what a node of a file points to."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(file), unquote(node.get("source", ""))))


def _content(files: Mapping[str, bytes], name: str) -> bytes:
    if name not in files:
        raise UncheckedError(f"{name} is not in the FMU")
    return files[name]


def _parsed(files: Mapping[str, bytes], name: str) -> Element:
    try:
        return ElementTree.fromstring(_content(files, name))
    except ElementTree.ParseError as error:
        raise UncheckedError(f"{name} is no XML: {error}") from None


def _columns(files: Mapping[str, bytes], name: str) -> dict[str, np.ndarray]:
    """The columns of a table that are numbers."""
    lines = io.StringIO(_content(files, name).decode("utf-8-sig", errors="replace"))
    names, *rows = [row for row in csv.reader(lines) if row] or [[]]
    if names[:1] != ["time"] or not rows or any(len(row) != len(names) for row in rows):
        raise UncheckedError(f"{name} must be a table with a column time, and rows of equal length")
    columns = {}
    for column, values in zip(names, zip(*rows, strict=True), strict=True):
        try:
            columns[column] = np.array(values, dtype=float)
        except ValueError:  # text, truth values, arrays
            continue
    if "time" not in columns or not (np.diff(columns["time"]) >= 0.0).all():
        raise UncheckedError(f"{name}: the column time must hold increasing numbers")
    return columns


def _number(text: str, what: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UncheckedError(f"{what} = {text!r} must be a finite number")
    return number


# --- comparing -------------------------------------------------------------------------------------------


def _checked(path: Path, description: Any, experiment: Experiment) -> str:
    """Simulate an experiment; return what was compared.

    Raises:
        UncheckedError: when an output deviates, or something cannot be compared.
    """
    variables = {variable.name: variable for variable in description.modelVariables}
    time, settings = experiment.results["time"], experiment.settings
    names = [name for name in experiment.results if name != "time"]
    if experiment.shared:
        names = [name for name in names if name in variables]
    for name in [*names, *(experiment.stimuli or {})]:
        if name not in variables and name != "time":
            raise UncheckedError(f"the FMU has no variable {name}")
    if not names:
        raise UncheckedError("not run: there is no column of numbers to compare", wrong=False)
    if HOST not in platforms_of(path):
        raise UncheckedError(f"not run: the FMU has no binary for {HOST}", wrong=False)
    default = getattr(description.defaultExperiment, "stepSize", None)
    step = settings.get("stepSize", float(default) if default else float(np.diff(time).min(initial=math.inf)))
    rows = simulated(
        path,
        description,
        output=names,
        start_time=settings.get("startTime", float(time[0])),
        stop_time=max(float(time[-1]), settings.get("stopTime", -math.inf)),
        output_interval=step,
        input=_structured(experiment.stimuli),
    )
    stated = experiment.tolerances
    deviating = {}
    for name in names:
        expected, found = experiment.results[name], np.interp(time, rows["time"], rows[name].astype(float))
        allowed = stated.get(name, SHARE * float(np.ptp(expected) or np.abs(expected[0])))
        # so written that a NaN deviates
        off = np.flatnonzero(~(np.abs(found - expected) <= allowed))
        if off.size:
            deviating[name] = (off[0], found[off[0]], expected[off[0]], allowed)
    if deviating:
        name = min(deviating, key=lambda name: deviating[name][0])
        row, found, expected, allowed = deviating[name]
        more = f"; {len(deviating)} of {len(names)} outputs deviate" if len(deviating) > 1 else ""
        raise UncheckedError(
            f"{name} = {found:.9g} in place of {expected:.9g} at t = {time[row]:.9g} s: "
            f"{abs(found - expected):.2g} off, {allowed:.2g} allowed{more}"
        )
    how = (
        "" if set(names) <= set(stated) else f", within {SHARE:.1%} of the range where no tolerance is stated"
    )
    return f"passed, outputs: {len(names)}, times: {len(time)}, until {time[-1]:.9g} s{how}"


def _structured(columns: Mapping[str, np.ndarray] | None) -> np.ndarray | None:
    """Columns as fmpy takes them."""
    if columns is None:
        return None
    table = np.zeros(len(columns["time"]), [(name, float) for name in ("time", *(columns.keys() - {"time"}))])
    for name, values in columns.items():
        table[name] = values
    return table
