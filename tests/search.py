"""The random search: scenes run in processes of their own, which a timer ends when they take too long.

``verdict(scene, seed)`` for one; ``verdicts(seeds)`` for many, on as many cores as wanted. A run that exceeds its CPU
time is killed by the timer of its process (SIGPROF, whose default ends it: no code of Python has to run, nor of the
kernel); the parent sees the pipe close, says how far the run came, and starts another process.
"""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import get_context
from queue import SimpleQueue
from typing import Any

from chain_impact.compilation.library import kernel_library
from chain_impact.kernel.status import OK
from chain_impact.scene import Scene
from chain_impact.simulate import load_kernel
from tests import oracle
from tests.oracle import CPU, Finding
from tests.random_scenes import scene as scene_of

CONTEXT = get_context("forkserver")
CONTEXT.set_forkserver_preload(["tests.search"])


@dataclass
class Verdict:
    """What is said of one run."""

    seed: int
    law: str
    method: str
    findings: list[Finding]
    status: int | None = OK  # None: it did not end
    cpu: float = 0.0  # s
    counts: dict[str, int] = field(default_factory=dict)
    closeness: dict[str, float] = field(default_factory=dict)  # kind of check → value over bound

    @property
    def kinds(self) -> list[str]:
        return sorted({finding.kind for finding in self.findings})

    def __str__(self) -> str:
        return f"scene({self.seed}), {self.law}, {self.method}: " + "; ".join(map(str, self.findings))


def verdict(scene: Scene, seed: int, cpu: float = CPU) -> Verdict:
    """Run a scene, with the inputs of a seed, and judge it."""
    worker = Worker()
    try:
        return worker.ask(scene, seed, cpu)
    finally:
        worker.close()


def verdicts(seeds: Iterable[int], cpu: float = CPU, cores: int = 1) -> Iterator[Verdict]:
    """The verdicts on the scenes of many seeds, in their order."""
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


def tally(found: Iterable[Verdict]) -> Counter[tuple[str, str, str]]:
    """How many verdicts have each kind of finding: (kind, law, method) → count."""
    return Counter((kind, one.law, one.method) for one in found for kind in one.kinds)


class Worker:
    """A process that runs scenes one after the other; another takes its place when it was ended."""

    def __init__(self) -> None:
        self.process: Any = None

    def ask(self, scene: Scene | None, seed: int, cpu: float) -> Verdict:
        if self.process is None:
            self.start()
        self.reached.value = 0.0
        try:
            self.pipe.send((scene, seed, cpu))
            result = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            ended, code = self.reached.value, self.process.exitcode
            self.close()
            return _ended(scene or scene_of(seed), seed, cpu, ended, code)
        if isinstance(result, Exception):
            raise result
        return result

    def start(self) -> None:
        self.reached = CONTEXT.RawValue("d", 0.0)
        self.pipe, theirs = CONTEXT.Pipe()
        self.process = CONTEXT.Process(target=_serve, args=(theirs, self.reached), daemon=True)
        self.process.start()
        theirs.close()

    def close(self) -> None:
        if self.process is not None:
            self.pipe.close()
            self.process.kill()
            self.process.join()
        self.process = None


def _ended(scene: Scene, seed: int, cpu: float, reached: float, code: int) -> Verdict:
    stop = scene.simulation.stop_time
    if code == -signal.SIGPROF:
        text = f"CPU time [s] of a run that was ended between t = {reached:.6g} and the next output, of {stop:.6g} s"
        finding = Finding("slow", cpu, cpu, text)
    else:
        finding = Finding("crash", float(code), 0.0, f"the process died at t = {reached:.6g} s, of {stop:.6g} s")
    return Verdict(seed, scene.contact.model, scene.solver.method, [finding], status=None, cpu=cpu)


def _serve(pipe: Any, reached: Any) -> None:
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    while True:
        try:
            scene, seed, cpu = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send(_judged(scene or scene_of(seed), seed, cpu, reached))
        except Exception as error:  # of the search itself: the parent raises it
            pipe.send(RuntimeError(f"scene({seed}): {error!r}"))


def _judged(scene: Scene, seed: int, cpu: float, reached: Any) -> Verdict:
    # a kernel that has to be compiled takes seconds, which are not the run's
    load_kernel(kernel_library(len(scene.chain.links), notify=lambda _: None))
    signal.setitimer(signal.ITIMER_PROF, cpu)
    run = oracle.account(scene, seed, partial(setattr, reached, "value"))
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    counts = {**run.statistics, "impacts": len(run.impacts)}
    rows = list(oracle.checks(run, cpu))
    closeness = {kind: value / bound for kind, value, bound, _ in rows if bound > 0.0}
    law, method = scene.contact.model, scene.solver.method
    return Verdict(seed, law, method, oracle.judge(run, cpu), run.status, run.cpu, counts, closeness)
