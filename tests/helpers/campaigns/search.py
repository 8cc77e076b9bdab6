"""The random search: scenes run in separate processes, which a timer ends if they take too long.

``verdict(scene, seed)`` judges one scene, ``verdicts(seeds)`` many scenes on several cores. The timer of its
process kills a run that exceeds its CPU time (SIGPROF, whose default action needs no code of Python or of the
kernel). The parent then sees the pipe close, reports how far the run came, and starts another process for the
next scene.

``python -m tests.helpers.campaigns.search --count 20000`` searches more scenes than the tests, and prints the
findings by kind, with their seeds. Special kinds of scenes begin at whole millions (``--first``), which
random_scenes.py lists.
"""

from __future__ import annotations

import argparse
import os
import signal
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from queue import SimpleQueue
from typing import Any

import numpy as np

from chain_impact.compilation.library import kernel_library
from chain_impact.kernel.status import OK, STATUS_TEXT
from chain_impact.scene.scene import Scene
from chain_impact.simulation.kernels import load_kernel
from chain_impact.variables.prepared import as_prepared
from tests.helpers.campaigns import oracle
from tests.helpers.campaigns.oracle import CPU, Finding
from tests.helpers.campaigns.random_scenes import scene as scene_of

MEMORY = 200_000  # number of numbers for the record of any scene
# [1/s] the least evaluations per second of CPU time; fewer are a sign of a loop without evaluations
SLOWEST = 1e4
CONTEXT = get_context("forkserver")
CONTEXT.set_forkserver_preload([__name__])


@dataclass
class Verdict:
    """The result of one run."""

    seed: int
    law: str
    method: str
    findings: list[Finding]
    status: int | None = OK  # None if the run did not end
    cpu: float = 0.0  # s
    closeness: dict[str, float] = field(default_factory=dict)  # kind of check → largest value over its bound

    @property
    def kinds(self) -> list[str]:
        return sorted({finding.kind for finding in self.findings})

    def __str__(self) -> str:
        return f"scene({self.seed}), {self.law}, {self.method}: " + "; ".join(map(str, self.findings))


def verdict(scene: Scene, seed: int, cpu: float = CPU) -> Verdict:
    """Return the verdict on a run of a scene with a seed's inputs, in at most ``cpu`` [s] of CPU time."""
    worker = Worker()
    try:
        return worker.ask(scene, seed, cpu)
    finally:
        worker.close()


def verdicts(seeds: Iterable[int], cpu: float = CPU, cores: int = 1) -> Iterator[Verdict]:
    """Return the verdicts on the scenes of many seeds, in the order of the seeds."""
    idle: SimpleQueue[Worker] = SimpleQueue()
    workers = [Worker() for _ in range(cores)]
    for worker in workers:
        idle.put(worker)

    def one(seed: int) -> Verdict:
        worker = idle.get()
        try:
            return worker.ask(None, seed, cpu)
        finally:
            idle.put(worker)

    try:
        with ThreadPoolExecutor(cores) as pool:
            yield from pool.map(one, seeds)
    finally:
        for worker in workers:
            worker.close()


class Worker:
    """A process that runs scenes one after the other; if the process is ended, another replaces it."""

    def __init__(self) -> None:
        self.process: Any = None

    def ask(self, scene: Scene | None, seed: int, cpu: float) -> Verdict:
        if self.process is None:
            self.start()
        try:
            self.pipe.send((scene, seed, cpu))
            result = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            code = self.process.exitcode
            self.close()
            return _ended(scene or scene_of(seed), seed, cpu, self.memory, code)
        if isinstance(result, Exception):
            raise result
        return result

    def start(self) -> None:
        self.memory = CONTEXT.RawArray("d", MEMORY)
        self.pipe, theirs = CONTEXT.Pipe()
        self.process = CONTEXT.Process(target=_serve, args=(theirs, self.memory), daemon=True)
        self.process.start()
        theirs.close()

    def close(self) -> None:
        if self.process is not None:
            self.pipe.close()
            self.process.kill()
            self.process.join()
        self.process = None


def _ended(scene: Scene, seed: int, cpu: float, memory: Any, code: int) -> Verdict:
    """Return the verdict on a run that was ended, from the record that it left."""
    record = np.frombuffer(memory, as_prepared(scene).start.dtype, count=1)[0]
    statistics = record["statistics"]
    counts = {name: int(statistics[name]) for name in statistics.dtype.names}
    end, work = (
        float(record["step"]["end"]),
        f"{counts['steps']} steps, {counts['rhs_evaluations']} evaluations",
    )
    where = f"ended at {end:.6g} of {scene.simulation.stop_time:.6g} s after {work}"
    if code == -signal.SIGPROF:
        hangs = counts["rhs_evaluations"] < cpu * SLOWEST
        finding = Finding("hang" if hangs else "slow", cpu, cpu, f"CPU time [s], {where}")
    else:
        finding = Finding("crash", float(abs(code)), 0.0, f"the process died, {where}")
    return Verdict(seed, scene.contact.model, scene.solver.method, [finding], None, cpu)


def _serve(pipe: Any, memory: Any) -> None:
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    while True:
        try:
            scene, seed, cpu = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send(_judged(scene or scene_of(seed), seed, cpu, memory))
        except Exception as error:  # an error of the search itself, which the parent raises
            pipe.send(RuntimeError(f"scene({seed}): {error!r}"))


def _judged(scene: Scene, seed: int, cpu: float, memory: Any) -> Verdict:
    # the compilation of a kernel takes seconds, which do not belong to the run
    load_kernel(kernel_library(len(scene.chain.links)))
    signal.setitimer(signal.ITIMER_PROF, cpu)
    run = oracle.account(scene, seed, memory)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    rows = list(oracle.checks(run, cpu))
    closeness = {kind: value / bound for kind, value, bound, _ in rows if bound > 0.0}
    law, method = scene.contact.model, scene.solver.method
    return Verdict(seed, law, method, oracle.findings(rows), run.status, run.cpu, closeness)


def main() -> None:
    """Search, and print the findings."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=20000, help="scenes")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--cores", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--cpu", type=float, default=CPU, help="CPU time that a run may take [s]")
    options = parser.parse_args()
    ends: Counter[str] = Counter()
    texts_of_kinds: dict[str, list[str]] = defaultdict(list)
    for outcome in verdicts(range(options.first, options.first + options.count), options.cpu, options.cores):
        ends[
            "the process ended before the run" if outcome.status is None else STATUS_TEXT[outcome.status]
        ] += 1
        for kind in outcome.kinds:
            texts_of_kinds[kind].append(str(outcome))
    for title, texts in [
        ("ends", [f"{count} runs: {text}" for text, count in ends.most_common()]),
        *texts_of_kinds.items(),
    ]:
        print(f"{title}: {len(texts)}", *texts, sep="\n  ")


if __name__ == "__main__":
    main()
