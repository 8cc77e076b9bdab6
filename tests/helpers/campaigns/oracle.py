"""The checks of the random search: rules from the laws of physics and the docs that hold for every run.

The checks need no exact solution. Each check compares a value with a bound. Bounds of errors are those that
docs/computation.md promises: the tolerance times scales of the model. ``judge`` takes the results of a run
(``Account``) and returns ``Finding``s with numbers; ``search.verdict`` runs a scene in a separate process
with a time limit, so that a hang is a finding (tests/helpers/campaigns/search.py).
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np

from chain_impact.kernel.status import OK, STATUS_TEXT, TOO_MUCH_WORK
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.scene import Scene
from chain_impact.simulation.errors import SimulationError
from tests.helpers.campaigns.load_checks import load_checks
from tests.helpers.campaigns.oracle_energy import (
    INTERPOLATED,
    SAFETY,
    available,
    dissipation_bound,
    energy_bound,
    expected,
    spring_moments,
)
from tests.helpers.campaigns.oracle_friction import friction_checks
from tests.helpers.campaigns.random_scenes import drive, started
from tests.helpers.kernel.kernel_calls import move

CPU = 2.0  # [s] CPU time that a run may take
ROWS = 50  # number of communication points, in addition to the start
OUTSIDE = 1e-9  # [m] largest distance of a point beyond a wall that is not reported as a penetration
DEEPER = 3.0  # largest depth, over the depth that the available energy can reach
# time after the end of a contact for which its point may be inside the wall, over the contact's time scale
LEFT = 0.01
ROUND_OFF = 1e-12  # largest speed of unknown sign, over the speeds of the chain and a link length per second
Row = tuple[str, float, float, str]  # a row of a check: kind, value, bound, and words for the value


@dataclass(frozen=True)
class Law:
    """The law of a candidate, for a stop as a law of the joint's angle; a rigid law has the stiffness 0."""

    point: int
    wall: int
    stop: bool
    model: str
    stiffness: float
    exponent: float
    slowest: float  # m/s or rad/s, the least speed that v₀ may have
    unit: float  # m: 1, or for a stop the longest link, on which an error of an angle in rad acts


def laws(scene: Scene) -> list[Law]:
    """Return the law of each candidate."""
    contact, stops, all_laws = scene.contact, scene.stops, []
    size = max(link.length for link in scene.chain.links)
    for point, wall in candidates_of(scene):
        name = scene.wall_names[wall]
        stop = name in ("joint_min", "joint_max") and bool(scene.chain.stops)
        model = (stops.model or contact.model) if stop else contact.model
        own = contact.wall.get(name)
        stiffness = stops.stiffness if stop else (own and own.stiffness) or contact.stiffness
        exponent, slowest = (
            (stops.exponent, stops.minimum_impact_speed)
            if stop
            else (contact.exponent, contact.minimum_impact_speed)
        )
        rigid = model == "newton_impact"
        unit = size if stop else 1.0
        all_laws.append(Law(point, wall, stop, model, 0.0 if rigid else stiffness, exponent, slowest, unit))
    return all_laws


def columns(every: list[Law], impacts: np.ndarray) -> SimpleNamespace:
    """Return the laws of a run's impacts as columns, a row for each impact."""
    by_candidate = {(law.point, law.wall): law for law in every}
    rows = [by_candidate[int(row["point"]), int(row["wall"])] for row in impacts]
    names = ("stiffness", "exponent", "slowest", "unit", "stop")
    return SimpleNamespace(**{name: np.array([getattr(row, name) for row in rows]) for name in names})


@dataclass(frozen=True)
class Columns:
    """The data of a chain's links, as columns; ``ratio`` is the centre of mass over the length."""

    length: np.ndarray
    mass: np.ndarray
    ratio: np.ndarray
    inertia: np.ndarray

    @property
    def size(self) -> float:
        return float(self.length.max())

    @property
    def energy(self) -> float:
        """The energy Σ m s²/s² [J], the scale of the error norm."""
        return float(self.mass.sum()) * self.size**2


def chain_of(scene: Scene) -> Columns:
    """Return the links of a scene."""
    rows = [
        (link.length, link.mass, link.center_of_mass / link.length, link.inertia)
        for link in scene.chain.links
    ]
    return Columns(*np.transpose(rows))


@dataclass(frozen=True)
class Finding:
    """A failed check: its kind, the value and the bound that the value exceeds, and a sentence."""

    kind: str
    value: float
    bound: float
    text: str

    def __str__(self) -> str:
        return f"{self.kind}: {self.text} ({self.value:.3g}, at most {self.bound:.3g})"


@dataclass
class Account:
    """The results of a run: rows of outputs at the reached times, contacts, counts."""

    scene: Scene
    time: np.ndarray  # s
    outputs: np.ndarray
    impacts: np.ndarray
    statistics: dict[str, int]
    cpu: float  # s
    refused: bool = False  # whether the run could not start
    tip: np.ndarray = field(default_factory=lambda: np.zeros(2))  # N, force of an input on the tip
    torque: float = 0.0  # N·m, sum of the torques in all joints

    @property
    def push(self) -> float:
        return float(np.linalg.norm(self.tip))

    def centres(self, name: str) -> np.ndarray:
        """Return a vector output of the points at the centres of mass."""
        points, ratio = self.outputs[name], self.chain.ratio[:, None]
        return points[:, :-1] + ratio * np.diff(points, axis=1)

    @property
    def status(self) -> int:
        return self.statistics["status"]

    @cached_property
    def laws(self) -> list[Law]:
        return laws(self.scene)

    @cached_property
    def laws_of_impacts(self) -> Any:
        return columns(self.laws, self.impacts)

    @cached_property
    def chain(self) -> Columns:
        return chain_of(self.scene)


def account(scene: Scene, seed: int, memory: Any = None, rows: int = ROWS) -> Account:
    """Run a scene with the inputs of a seed, and return the results, at ``rows`` times after the start.

    The run is in this process, with its record in ``memory``, if given, so that others can read it. A scene
    that cannot start gives an account without rows, which is ``refused``.
    """
    begin = time.process_time()
    times = np.linspace(0.0, scene.simulation.stop_time, rows + 1)
    try:
        instance = started(scene, seed)
    except SimulationError as error:
        none = np.zeros(0)
        cpu = time.process_time() - begin
        return Account(scene, none, none, none, {"status": error.status, "steps": 0}, cpu, refused=True)
    if memory is not None:
        move(instance, memory)
    torque, force = drive(scene, seed)
    outputs = np.zeros(len(times), instance.record.dtype["output"])
    completed, impacts = 0, []
    while completed < len(times) and instance.status == OK:
        completed += instance.trajectory(times[completed:], outputs[completed:])
        impacts.append(instance.collect())
    impacts.append(instance.open_contacts())
    statistics, cpu = instance.statistics, time.process_time() - begin
    rows = np.concatenate(impacts)
    turn = float(np.abs(torque).sum())
    return Account(
        scene, times[:completed], outputs[:completed], rows, statistics, cpu, tip=force, torque=turn
    )


def judge(run: Account, cpu: float = CPU) -> list[Finding]:
    """Return the findings on a run."""
    return findings(checks(run, cpu))


def findings(rows: Iterable[Row]) -> list[Finding]:
    """Return a finding for each failed check."""
    return [Finding(*row) for row in rows if not row[1] <= row[2]]


def checks(run: Account, cpu: float = CPU) -> Iterator[Row]:
    """Return all checks of a run, as rows."""
    yield "slow", run.cpu, cpu, "CPU time [s]"
    if run.refused:
        yield "refused", 1.0, 0.0, f"a valid scene does not start: {STATUS_TEXT[run.status]}"
        return
    if run.status not in (OK, TOO_MUCH_WORK):
        yield (
            "stopped",
            1.0,
            0.0,
            f"after {run.time[-1] if len(run.time) else 0.0:.3g} s: {STATUS_TEXT[run.status]}",
        )
    outputs = run.outputs
    # parts of the record as numbers; all numbers in them are reals
    numbers = {name: np.frombuffer(outputs[name].tobytes()) for name in outputs.dtype.names}
    bad = [name for name, values in numbers.items() if not np.isfinite(values).all()]
    # the end and the separation speed of an open contact are unknown
    columns = ("onset", "impact_speed", "peak_force", "max_penetration", "effective_mass")
    bad += [name for name in columns if not np.isfinite(run.impacts[name]).all()]
    yield "not finite", float(len(bad)), 0.0, f"outputs or impacts that are not finite: {bad}"
    if bad or not len(outputs):
        return
    balance = outputs["total"] + outputs["dissipated"] - outputs["supplied"]
    if run.status == OK:
        yield "energy", float(np.ptp(balance)), energy_bound(run), "drift of the energy balance [J]"
    fall = float((np.maximum.accumulate(outputs["dissipated"]) - outputs["dissipated"]).max())
    yield "undissipated", fall, dissipation_bound(run), "fall of the dissipated energy [J]"
    elastic = {law.model for law in run.laws} == {"hertz"}
    if elastic and not any(link.joint_damping for link in run.scene.chain.links):
        lost = float(np.abs(outputs["dissipated"] - outputs["friction"]["dissipated"]).max())
        yield "dissipates", lost, dissipation_bound(run), "energy that an elastic wall has taken [J]"
    yield from containment(run)
    yield from friction_checks(run.scene, outputs)
    yield from speeds(run)
    yield from contact_times(run)
    yield from falls(run.scene, outputs)
    yield from load_checks(run)


# --- walls -------------------------------------------------------------------------------------------------


def containment(run: Account) -> Iterator[Row]:
    """Check that points beyond a wall or stop touch it, without a pull, and no deeper than energy allows."""
    every = run.laws
    if not every:
        return
    reach = run.chain.size + run.chain.length.sum()
    # a held point is moved to its wall after each step; in between it has the error of its position
    held = INTERPOLATED * run.scene.solver.tolerance * reach
    slack = np.array([(OUTSIDE + held * (law.stiffness == 0.0)) / law.unit for law in every])
    force, depth = by_candidate(run, "force"), by_candidate(run, "penetration")
    unseen = float((-clearances(run) - depth - left_inside(run) - slack).max())
    yield "outside", unseen, 0.0, "outside a wall, or beyond a stop, more than is reported [m, rad]"
    yield "pulls", float(-force.min()), 0.0, "a wall or a stop pulls [N, N·m]"
    energy = float(available(run).max()) + energy_bound(run)
    for c, law in enumerate(every):
        deepest = float(depth[:, c].max())
        if run.status == OK:  # otherwise contacts continue after the last row
            own = (run.impacts["point"] == law.point) & (run.impacts["wall"] == law.wall)
            deepest = max(deepest, float(run.impacts["max_penetration"][own].max(initial=0.0)))
        yield "too deep", deepest, depth_bound(run, law, energy), f"penetration of candidate {c} [m, rad]"


def left_inside(run: Account) -> np.ndarray:
    """Return how deep each candidate, in each row, may be after the end of its contact [m; at stops rad].

    A contact ends when its point will leave the wall within LEFT of the time scale δ*/v₀.
    """
    depth = np.zeros_like(run.outputs["penetration"])
    column = {candidate: c for c, candidate in enumerate(candidates_of(run.scene))}
    v0, foreseen = expected(run)
    for row, speed, scale in zip(run.impacts, v0, foreseen, strict=True):
        since = run.time - row["end"]
        rows = (since >= 0.0) & (since <= SAFETY * LEFT * scale / speed)
        depth[rows, column[int(row["point"]), int(row["wall"])]] = LEFT * scale
    return depth


def clearances(run: Account) -> np.ndarray:
    """Return the clearance of each candidate in each row [m]; for a stop [rad]."""
    scene, places = run.scene, run.outputs["point_position"]
    joints = np.diff(run.outputs["angle"], axis=1, prepend=0.0)
    columns = []
    for law in run.laws:
        name = scene.wall_names[law.wall]
        if law.stop:
            joint, link = joints[:, law.point - 1], scene.chain.links[law.point - 1]
            columns.append(joint - link.joint_min if name == "joint_min" else link.joint_max - joint)
        else:
            wall = scene.half_planes[name]
            columns.append(places[:, law.point] @ wall.normal - wall.offset - scene.contact.radius)
    return np.transpose(columns)


def by_candidate(run: Account, name: str) -> np.ndarray:
    """Return the forces or penetrations of candidates in each row.

    Those of joints belong to the nearer stop.
    """
    values, every = run.outputs[name].copy(), run.laws
    gaps = clearances(run)
    for c, law in enumerate(every):
        if law.stop and c > 0 and every[c - 1].stop and every[c - 1].point == law.point:
            # the first stop of a joint, joint_min, has the values of both stops
            upper = gaps[:, c] < gaps[:, c - 1]
            values[:, c] = np.where(upper, values[:, c - 1], 0.0)
            values[:, c - 1] = np.where(upper, 0.0, values[:, c - 1])
        if name == "force" and run.scene.wall_names[law.wall] == "joint_max" and law.stop:
            values[:, c] *= -1.0
    return values


def depth_bound(run: Account, law: Law, energy: float) -> float:
    """Return DEEPER times the sum of the depth δ with K δⁿ⁺¹/(n+1) = ``energy`` [J] and the depth at rest.

    At rest, K δⁿ = weight + tip force; for a stop, this force times the length of the chain, plus the torques
    of the inputs and of the other joints' springs. The result is 0 for a rigid wall.
    """
    if law.stiffness == 0.0:
        return 0.0
    n, k = law.exponent, law.stiffness
    force = run.chain.mass.sum() * np.linalg.norm(run.scene.gravity) + run.push
    if law.stop:
        force = force * run.chain.length.sum() + run.torque + spring_moments(run).sum()
    return float(DEEPER * ((energy * (n + 1) / k) ** (1 / (n + 1)) + (force / k) ** (1 / n)))


def speeds(run: Account) -> Iterator[Row]:
    """Check that points move into the wall when contacts begin, and away from it when they end."""
    fastest = run.chain.size + float(np.linalg.norm(run.outputs["point_velocity"], axis=2).max())
    for name in ("impact_speed", "separation_speed"):
        contact_speeds = run.impacts[name][~np.isnan(run.impacts[name])]
        least = float(
            (contact_speeds * run.laws_of_impacts.unit[~np.isnan(run.impacts[name])]).min(initial=0.0)
        )
        yield f"negative {name}", -least, ROUND_OFF * fastest, f"{name} below zero by [m/s]"


def contact_times(run: Account) -> Iterator[Row]:
    """Check that contacts begin after the start, end after they begin, and not after the end of the run."""
    onset, end = run.impacts["onset"], run.impacts["end"]
    last = run.scene.simulation.stop_time if run.status == OK else np.inf
    over = ~np.isnan(end)
    late = max(float(onset.max(initial=0.0)), float(end[over].max(initial=0.0))) - last
    yield "too late", late, 0.0, "a contact after the stop time [s]"
    yield "too early", -float(onset.min(initial=0.0)), 0.0, "a contact before the start [s]"
    backwards = float((onset - end)[over].max(initial=0.0))
    yield "backwards", backwards, 0.0, "a contact that ends before it begins [s]"


# --- impulses ----------------------------------------------------------------------------------------------


def falls(scene: Scene, outputs: Any) -> Iterator[Row]:
    """Check that no impulse of a wall falls between rows; return kind, value, bound and words.

    An impulse may fall by ten times the tolerance of its largest value, or by round-off of a momentum.
    """
    mass, size = sum(link.mass for link in scene.chain.links), max(link.length for link in scene.chain.links)
    for c, (point, wall) in enumerate(candidates_of(scene)):
        # one output is the sum for both stops of a joint, negative at joint_max, and so may fall
        if not scene.wall_names[wall].startswith("joint_"):
            impulse = outputs["impulse"][:, c]
            least = 10.0 * scene.solver.tolerance * float(np.abs(impulse).max()) + ROUND_OFF * mass * size
            fall = float((np.maximum.accumulate(impulse) - impulse).max())
            yield (
                "falls",
                fall,
                least,
                f"fall of the impulse of point {point} at {scene.wall_names[wall]} [N·s]",
            )
