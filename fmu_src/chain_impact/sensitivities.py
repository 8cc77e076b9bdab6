"""Stand-in for derivatives beside the run: central differences of ordinary runs, behind the agreed names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from chain_impact.compilation.work import Notify, announce
from chain_impact.instance import new_instance
from chain_impact.kernel.status import OK
from chain_impact.reading import UnknownNameError
from chain_impact.results.result import IMPACT_DTYPE
from chain_impact.running import Instance, SimulationError, in_order
from chain_impact.scene import Scene
from chain_impact.variables import fmu_variables, output_words, word_index


@dataclass(frozen=True)
class Differentiated:
    values: np.ndarray
    slopes: np.ndarray
    impacts: np.ndarray
    impact_slopes: dict[str, np.ndarray]
    status: int
    limits: tuple[str, ...] = field(default=())


class DifferentiatedRun:
    def __init__(
        self,
        scene: Scene,
        parameters: Sequence[str],
        outputs: Sequence[str],
        inputs: object = None,
        notify: Notify = announce,
    ) -> None:
        scene = scene.with_values({"solver.tolerance": 1e-10})
        known = {v.name: v for v in fmu_variables(scene) if v.causality in ("parameter", "input")}
        for name in parameters:
            if name not in known:
                raise UnknownNameError(scene.name, name, known, "no parameter")
        self._instance = Instance(scene, notify)
        self._start = new_instance(scene)
        layout = self._start.dtype
        self._places = [word_index(layout, known[name].place) for name in parameters]
        self._extra = [
            word_index(layout, ("contact", known[name].place[1]))
            if known[name].place[0] == "given" and name.startswith("contact.")
            else None
            for name in parameters
        ]
        self._words = list(output_words(scene, outputs).values()) if outputs else []
        self._rows = np.zeros(0, layout["output"])

    def _plain(self, values: np.ndarray, times: np.ndarray):
        words = self._instance.words
        words[:] = self._start.view(np.float64)
        for place, extra, value in zip(self._places, self._extra, values, strict=True):
            words[place] = value
            if extra is not None:
                words[extra] = value
        found = np.full((len(times), len(self._words)), np.nan)
        try:
            self._instance.initialize()
        except SimulationError as error:
            return found, np.zeros(0, IMPACT_DTYPE), error.status
        if len(self._rows) != len(times):
            self._rows = np.zeros(len(times), self._start.dtype["output"])
        impacts, done = [], 0
        while done < len(times) and self._instance.status == OK:
            end = min(done + 50, len(times))
            n = self._instance.trajectory(times[done:end], self._rows[done:end])
            done += n
            impacts.append(self._instance.collect())
        impacts.append(self._instance.open_contacts())
        found[:done] = self._rows.view(np.float64).reshape(len(times), -1)[:done, self._words]
        return found, in_order(impacts), self._instance.status

    def run(self, values: np.ndarray, times: np.ndarray) -> Differentiated:
        values, times = np.asarray(values, float), np.ascontiguousarray(times, float)
        y, impacts, status = self._plain(values, times)
        slopes = np.zeros((*y.shape, len(values)))
        names = [n for n in IMPACT_DTYPE.names if n not in ("point", "wall")]
        impact_slopes = {n: np.full((len(impacts), len(values)), np.nan) for n in names}
        for p, value in enumerate(values):
            h = 1e-6 * (abs(value) if value else 1.0)
            ends = []
            for sign in (1, -1):
                changed = values.copy()
                changed[p] += sign * h
                ends.append(self._plain(changed, times))
            (ya, ia, sa), (yb, ib, sb) = ends
            if sa != OK:
                ya, ia, h = y, impacts, h / 2
            elif sb != OK:
                yb, ib, h = y, impacts, h / 2
            slopes[:, :, p] = (ya - yb) / (2 * h)
            n = min(len(impacts), len(ia), len(ib))
            with np.errstate(invalid="ignore"):
                for name in names:
                    impact_slopes[name][:n, p] = (ia[name][:n] - ib[name][:n]) / (2 * h)
        return Differentiated(y, slopes, impacts, impact_slopes, status)
