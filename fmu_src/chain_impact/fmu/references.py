"""Reference results inside the FMU: an experiment, what the FMU shall give in it, and how exactly.

They lie where the layered standard FMI-LS-REF (1.0.0-beta.1, Modelica Association, 2026) has them: a manifest
names a file of experiments (MA-HS-Experiments, Modelica Association, 2026), which names tables of inputs and
results. The Reference-FMUs of the Modelica Association carry such a manifest with one table. Neither has a
place for the tolerances of a comparison, so these are an annotation of the results.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.fmu.description import nominal_values
from chain_impact.progress import log
from chain_impact.scene.scene import Scene
from chain_impact.simulation.chain import Chain
from chain_impact.simulation.instance import SimulationError
from chain_impact.variables.model import Model
from chain_impact.variables.variable import Variable

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = f"{FOLDER}/fmi-ls-manifest.xml"
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
TOLERANCES = "chain-impact.tolerances"
"""The type of the annotation."""

EXACT = 1e-12  # tolerance of the reference
ROWS = 100  # communication steps of the scene's time, about
SHORTER = 10  # a part of the scene's time that is tried, when the results can be relied on in no more of it
# A chain amplifies an error with each impact. The experiment ends before the scene's own tolerance leads
# farther from the reference than LARGEST, or that tolerance, of the largest value of a unit. Tolerated is
# MARGIN times as far as it led until there, and at least LEAST of that value.
LARGEST, MARGIN, LEAST = 1e-5, 10.0, 1e-9
CLOSE = 1e-4  # of a step: nearer to the begin or the end of a contact, nothing is compared
MOST_WORK = 2_000_000  # evaluations of the equations of motion, times links: about 0.2 s
SWING = 0.1  # of the inputs, of the magnitudes of the motion
FEWEST, DIGITS = 2, 12  # rows: the start alone is no simulation; digits of a result

# the version is the one that the document of 1.0.0-beta.1 prescribes
MANIFEST_TEXT = f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:fmi-ls="{NAMESPACE}" fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref"
    fmi-ls:fmi-ls-version="1.0.0-alpha.1"
    fmi-ls:fmi-ls-description="Layered Standard providing information on related files included in an FMU.">
  <Related type="application/x-ma-hs-experiments" source="{{name}}.exp" role="experiment/smoke-test"
      description="An experiment and its results"/>
  <Related type="text/csv" source="{{name}}_out.csv" role="result" description="Outputs until {{stop}} s"/>
</fmiReferences>
"""
ABOUT = (
    f"Start values of the FMU. The results were computed at a tolerance of {EXACT:g}; the stated tolerances "
    f"are {MARGIN:g} times what the FMU's own tolerance makes of them"
)
EXPERIMENT_TEXT = f"""\
<?xml version="1.0" encoding="UTF-8"?>
<Experiments name="{{name}}" description="Is the import right?">
  <Experiment name="default"
      description="{ABOUT}"
      startTime="0.0" stopTime="{{stop}}" stepSize="{{step}}" tolerance="{{tolerance}}">
    {{stimuli}}<References source="{{name}}_out.csv">
      <Annotations>
        <Annotation type="{TOLERANCES}">
          {{tolerances}}
        </Annotation>
      </Annotations>
    </References>
  </Experiment>
</Experiments>
"""


@dataclass(frozen=True)
class Reference:
    """An experiment of a scene.

    Attributes:
        step: communication step [s].
        outputs: M of the FMU's outputs.
        times: communication points at which they are compared, shape (T,) [s]; the last one is the end.
        values: what they are, shape (T, M).
        tolerances: how far from these they may be, shape (M,).
        inputs: name of an input → its values, each from a communication point to the next, shape (S + 1,) for
            S steps.
    """

    step: float
    outputs: Sequence[Variable]
    times: np.ndarray
    values: np.ndarray
    tolerances: np.ndarray
    inputs: dict[str, np.ndarray]


def reference_files(model: Model) -> dict[str, bytes]:
    """The files, by their names in the FMU; none if the results cannot be relied on for any time.

    Args:
        model: what the FMU simulates.
    """
    try:
        found = reference(model)
    except SimulationError as error:
        log.info("no reference results in the FMU: %s", error)
        return {}
    if len(found.times) < FEWEST:
        log.info("no reference results in the FMU: they depend too much on the solver's tolerance")
        return {}
    scene, name = model.scene, model.scene.name
    files = {
        "fmi-ls-manifest.xml": MANIFEST_TEXT.format(name=name, stop=f"{found.times[-1]:.9g}").encode(),
        f"{name}.exp": _experiments(scene, found).encode(),
        f"{name}_out.csv": _table(found.times, [v.name for v in found.outputs], found.values),
    }
    if found.inputs:
        times = np.arange(len(next(iter(found.inputs.values())))) * found.step
        files[f"{name}_in.csv"] = _table(times, found.inputs, np.transpose(list(found.inputs.values())))
    return {f"{FOLDER}/{file}": content for file, content in files.items()}


def reference(model: Model) -> Reference:
    """Simulate a scene at a tolerance of 1e-12 and at its own, as far as the second follows the first.

    If that is a small part of the scene's time, in shorter steps.

    Raises:
        SimulationError: when it cannot start, or take the first step.
    """
    stop, shortest = model.scene.simulation.stop_time, model.scene.simulation.step_size
    while True:
        step = shortest * max(1, round(stop / shortest / ROWS))
        count = max(1, math.floor(stop / step * (1 + 1e-12)))
        found = _compared(model, np.minimum(np.arange(count + 1) * min(step, stop), stop))
        if len(found.times) > ROWS / SHORTER or step == shortest:
            return found
        stop /= SHORTER


def _compared(model: Model, times: np.ndarray) -> Reference:
    """The reference with some communication points [s], equally spaced from 0."""
    scene, step = model.scene, float(times[1])
    inputs, chosen = _inputs(model, len(times)), _chosen(model)
    runs = [
        _Run(scene.with_values({"solver.tolerance": tolerance, "outputs.solver": True}))
        for tolerance in (EXACT, scene.solver.tolerance)
    ]
    for row, time in enumerate(times):
        acting = {name: values[max(row - 1, 0)] for name, values in inputs.items()}
        if sum(run.go_on(time, acting, chosen) for run in runs) < len(runs):
            break
    count = min(len(run.rows) for run in runs)
    exact, own = (np.array(run.rows[:count]).reshape(count, len(chosen)) for run in runs)
    onsets = [run.chain.impacts["onset"] for run in runs]
    until = _agreed_until(onsets[0], onsets[1], CLOSE * step / MARGIN)
    # a contact that lasts has no end yet, which is NaN
    edges = np.concatenate(
        [*(run.chain.impacts[end] for run in runs for end in ("onset", "end")), [math.inf]]
    )
    apart = np.nanmin(np.abs(times[:count, None] - edges), axis=1) > CLOSE * step
    rows = np.flatnonzero(apart & (times[:count] < until))
    scale, whole = _scales(exact[rows], chosen), [v.type != "real" for v in chosen]
    deviation = np.abs(own[rows] - exact[rows])
    largest = max(LARGEST, scene.solver.tolerance) * scale
    astray = (deviation > np.where(whole, 0.0, largest)).any(axis=1)
    rows = rows[: np.argmax(astray)] if astray.any() else rows
    worst = deviation[: len(rows)].max(axis=0, initial=0.0)
    steps = rows[-1] if len(rows) else 0
    return Reference(
        step=step,
        outputs=chosen,
        times=times[rows],
        values=exact[rows],
        tolerances=np.where(whole, 0.0, np.maximum(MARGIN * worst, LEAST * scale)),
        inputs={name: values[: steps + 1] for name, values in inputs.items()},
    )


class _Run:
    """A chain, and the rows of outputs that it gave."""

    def __init__(self, scene: Scene) -> None:
        self.chain = Chain(scene)
        self.rows: list[np.ndarray] = []
        self._links = len(scene.chain.links)

    def go_on(self, time: float, inputs: dict[str, float], outputs: Sequence[Variable]) -> bool:
        """Step to a time [s]; return whether that went well, and did not take too long.

        Raises:
            SimulationError: when the first step cannot be taken.
        """
        try:
            self.chain.set(inputs)
            self.chain.step_to(time)
            self.rows.append(self.chain.get([variable.name for variable in outputs]))
        except SimulationError:
            if len(self.rows) < FEWEST:
                raise
            return False
        return bool(self.chain.get("solver.rhs_evaluations") * self._links < MOST_WORK)


def _chosen(model: Model) -> list[Variable]:
    """A few outputs that together depend on all that happens."""
    last = len(model.scene.chain.links)
    ends = [f"point[{k}].{axis}" for k in (0, last) for axis in "xy"]
    ends += [f"link[{i}].angle" for i in (1, last)]
    return [v for v in model.outputs if v.name in ends or v.name.startswith(("energy.", "impact."))]


def _inputs(model: Model, count: int) -> dict[str, np.ndarray]:
    """A sine for each input, of another frequency each, so that none is taken for another."""
    nominal, links = nominal_values(model.scene), len(model.scene.chain.links)
    turn = 2.0 * math.pi * np.arange(count) / count
    # of a torque M L²/s², of a force M L/s², shared by the links
    size = {
        "joint": SWING * nominal["kinetic"] / links,
        "tip": SWING * nominal["kinetic"] / nominal["point_position"] / links,
    }
    return {
        name: size[name.partition(".")[0].partition("[")[0]] * np.cos((1 + i) * turn)
        for i, name in enumerate(variable.name for variable in model.inputs)
    }


def _agreed_until(exact: np.ndarray, own: np.ndarray, close: float) -> float:
    """Until when [s] all onsets of two runs are the same, within ``close`` [s]."""
    count = min(len(exact), len(own))
    apart = np.append(np.abs(exact[:count] - own[:count]) > close, True)
    first = int(np.argmax(apart))
    return float(min([math.inf, *exact[first:], *own[first:]]))


def _scales(values: np.ndarray, outputs: Sequence[Variable]) -> np.ndarray:
    """The largest value of each output's unit, shape (M,)."""
    largest = np.abs(values).max(axis=0, initial=0.0)
    units = np.array([variable.unit for variable in outputs])
    return np.array([largest[units == unit].max() for unit in units]) + EXACT


# --- the files -------------------------------------------------------------------------------------------


def _experiments(scene: Scene, found: Reference) -> str:
    stimuli = f'<Stimuli source="{scene.name}_in.csv"/>\n    ' if found.inputs else ""
    pairs = zip(found.outputs, found.tolerances, strict=True)
    tolerances = (f'<Tolerance name="{v.name}" absolute="{allowed:.2g}"/>' for v, allowed in pairs)
    return EXPERIMENT_TEXT.format(
        name=scene.name,
        stop=repr(float(found.times[-1])),
        step=repr(found.step),
        tolerance=repr(scene.solver.tolerance),
        stimuli=stimuli,
        tolerances="\n          ".join(tolerances),
    )


def _table(times: np.ndarray, names: Sequence[str] | dict[str, np.ndarray], values: np.ndarray) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *names])
    for time, row in zip(times, values, strict=True):
        writer.writerow([repr(float(time)), *(f"{value:.{DIGITS}g}" for value in row)])
    return text.getvalue().encode()
