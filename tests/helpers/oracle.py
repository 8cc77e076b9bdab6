"""The oracle of the random search: what a run of any scene must keep, from the laws of physics and the docs.

It knows no exact solution. Each check is a bound that follows from what the solver promises, as
docs/computation.md says it: errors of a step within the tolerance times scales of the model. ``judge`` looks
at what a run has given (``Account``) and returns ``Finding``s, each with its numbers; ``search.verdict`` runs
a scene in a process of its own, which is ended when it takes too long, so that a hang is a finding
(tests/helpers/search.py).
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
from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import SimulationError
from tests.helpers.kernel_calls import move
from tests.helpers.load_checks import load_checks
from tests.helpers.random_scenes import drive, started

CPU = 2.0  # s, that a run may take
ROWS = 50  # communication points, besides the start
SAFETY = 3.0  # of the tolerance: the error control steers by estimates, and scales are sampled
INTERPOLATED = 10.0  # times the error of a step, that of an output between steps
OUTSIDE = 1e-9  # m, that a point may be outside a wall, of what is not reported as penetration
DEEPER = 3.0  # times the depth that the energy there is can reach
LEFT = 0.01  # of the time scale of a contact, for which its point may be inside after the end
ROUND_OFF = 1e-12  # of the speeds that there are, and of a link length a second: a sign is not known better
FORCE = 1e-9  # of the limit of friction: an excess that is round-off
SMALL = 1e-8  # of the weight of the chain, and of its mass times a link length per second squared
EPSILON = 2.0**-52
Row = tuple[str, float, float, str]  # of a check: kind, value, the most that it may be, and what that is


@dataclass(frozen=True)
class Law:
    """The law of a candidate, of a stop in the angle of its joint; a rigid one has a stiffness of 0."""

    point: int
    wall: int
    stop: bool
    model: str
    stiffness: float
    exponent: float
    slowest: float  # m/s or rad/s
    unit: float  # m: 1, or the longest link, on which the errors of an angle in rad act


def laws(scene: Scene) -> list[Law]:
    """The law of each candidate."""
    contact, stops, found = scene.contact, scene.stops, []
    size = max(link.length for link in scene.chain.links)
    for point, wall in candidates(scene):
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
        found.append(Law(point, wall, stop, model, 0.0 if rigid else stiffness, exponent, slowest, unit))
    return found


def columns(every: list[Law], impacts: np.ndarray) -> SimpleNamespace:
    """The laws of contacts, as columns."""
    by_candidate = {(law.point, law.wall): law for law in every}
    rows = [by_candidate[int(row["point"]), int(row["wall"])] for row in impacts]
    names = ("stiffness", "exponent", "slowest", "unit", "stop")
    return SimpleNamespace(**{name: np.array([getattr(row, name) for row in rows]) for name in names})


@dataclass(frozen=True)
class Columns:
    """The links of a chain, as columns."""

    length: np.ndarray
    mass: np.ndarray
    ratio: np.ndarray
    inertia: np.ndarray

    @property
    def size(self) -> float:
        return float(self.length.max())

    @property
    def energy(self) -> float:
        """Σ m s²/s² [J], the scale of the norm."""
        return float(self.mass.sum()) * self.size**2


def chain_of(scene: Scene) -> Columns:
    """The links of a scene."""
    rows = [
        (link.length, link.mass, link.center_of_mass / link.length, link.inertia)
        for link in scene.chain.links
    ]
    return Columns(*np.transpose(rows))


@dataclass(frozen=True)
class Finding:
    """One check that failed: its kind, the value and the bound that it breaks, and a sentence."""

    kind: str
    value: float
    bound: float
    text: str

    def __str__(self) -> str:
        return f"{self.kind}: {self.text} ({self.value:.3g}, at most {self.bound:.3g})"


@dataclass
class Account:
    """What a run has given: rows of outputs at the times that it reached, contacts, counts."""

    scene: Scene
    time: np.ndarray  # s
    outputs: np.ndarray
    impacts: np.ndarray
    statistics: dict[str, int]
    cpu: float  # s
    refused: bool = False  # it did not even start
    tip: np.ndarray = field(default_factory=lambda: np.zeros(2))  # N, the force of an input on the tip
    torque: float = 0.0  # N·m, in all joints together

    @property
    def push(self) -> float:
        return float(np.linalg.norm(self.tip))

    def centres(self, name: str) -> np.ndarray:
        """A vector of the points, at the centres of mass."""
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
    """Run a scene in this process; its record lies in ``memory``, if given, for others to look at."""
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
    done, impacts = 0, []
    while done < len(times) and instance.status == OK:
        done += instance.trajectory(times[done:], outputs[done:])
        impacts.append(instance.collect())
    impacts.append(instance.open_contacts())
    statistics, cpu = instance.statistics, time.process_time() - begin
    rows = np.concatenate(impacts)
    turn = float(np.abs(torque).sum())
    return Account(scene, times[:done], outputs[:done], rows, statistics, cpu, tip=force, torque=turn)


def judge(run: Account, cpu: float = CPU) -> list[Finding]:
    """All that is wrong with a run."""
    return findings(checks(run, cpu))


def findings(rows: Iterable[Row]) -> list[Finding]:
    """Those that failed."""
    return [Finding(*row) for row in rows if not row[1] <= row[2]]


def checks(run: Account, cpu: float = CPU) -> Iterator[Row]:
    """All checks of a run."""
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
    # parts of the record are numbers as well, and all numbers are reals
    numbers = {name: np.frombuffer(outputs[name].tobytes()) for name in outputs.dtype.names}
    bad = [name for name, values in numbers.items() if not np.isfinite(values).all()]
    # the end and the separation speed of an open contact are not known
    columns = ("onset", "impact_speed", "peak_force", "max_penetration", "effective_mass")
    bad += [name for name in columns if not np.isfinite(run.impacts[name]).all()]
    yield "not finite", float(len(bad)), 0.0, f"outputs or impacts that are not finite: {bad}"
    if bad or not len(outputs):
        return
    ledger = outputs["total"] + outputs["dissipated"] - outputs["supplied"]
    if run.status == OK:
        yield "energy", float(np.ptp(ledger)), energy_bound(run), "drift of the ledger [J]"
    fall = float((np.maximum.accumulate(outputs["dissipated"]) - outputs["dissipated"]).max())
    yield "undissipated", fall, dissipation_bound(run), "fall of the dissipated energy [J]"
    elastic = {law.model for law in run.laws} == {"hertz"}
    if elastic and not any(link.joint_damping for link in run.scene.chain.links):
        lost = float(np.abs(outputs["dissipated"] - outputs["friction"]["dissipated"]).max())
        yield "dissipates", lost, dissipation_bound(run), "energy that an elastic wall has taken [J]"
    yield from containment(run)
    yield from friction_checks(run.scene, outputs)
    yield from speeds(run)
    yield from moments(run)
    yield from falls(run.scene, outputs)
    yield from load_checks(run)


# --- energy ------------------------------------------------------------------------------------------------


def energy_bound(run: Account) -> float:
    """How far the ledger may drift [J].

    The exact flow keeps the ledger, from wherever it starts; so the drift is the sum of what the errors of
    the steps change in it, and nothing amplifies them. One step may err by the tolerance times a scale for
    each component of the state (docs/computation.md, error norm); ``energy_scale`` is what this makes of the
    ledger, to first order. The errors of n steps add up like √n, as they have no sign in common, and an
    output between steps is an interpolation, which may err by ten times as much. SAFETY is for the rest: the
    solver steers by an estimate of a step's error, and the scale is sampled at some points only. The largest
    drift in the scenes of 2000 seeds was √n/2 times tolerance and scale.

    Round-off comes on top: a few units in the last place of the energies, and of the positions where walls
    are stiff, as a force F turns an error of a position into one of energy.
    """
    return per_step(run, energy_scale(run))


def per_step(run: Account, scale: float) -> float:
    """What errors of the tolerance times a scale [J], and round-off, make in all steps of a run [J]."""
    steps = max(1.0, float(run.statistics["steps"]))
    errors = SAFETY * max(INTERPOLATED, steps**0.5) * run.scene.solver.tolerance * scale
    return float(errors + steps * round_off(run))


def energy_scale(run: Account) -> float:
    """What an error of one, in the units of the error norm, changes in the ledger [J], at the most.

    Kinetic: with |δv₀| ≤ s/1s + |v₀| and |δω| ≤ 1 rad/s + |ω|, Σ m |v_C| |δv_C| + I |ω| |δω|. Potential: with
    |δx₀| ≤ s and |δθ| ≤ 1 rad, Σ m |g| |δx_C|. Dissipated: its scale in the norm. Elastic: F |δg| with the
    scale of the penetration, and k |φ| |δφ| with |δφ| ≤ 1 rad. Supplied energy is not controlled, but
    follows: its size counts.

    Motion that has more energy than there is counts as if it had just that: an explosion is no excuse of
    itself.
    """
    chain, outputs, there = run.chain, run.outputs, available(run)
    share = np.sqrt(np.minimum(1.0, there / np.maximum(outputs["kinetic"], 1e-300)))[:, None]
    base = chain.size + share * np.linalg.norm(outputs["point_velocity"][:, :1], axis=2)
    omega = share * np.abs(outputs["angular_velocity"])
    error = base + np.cumsum(chain.length * (1.0 + omega), axis=1)
    speed = share * np.linalg.norm(run.centres("point_velocity"), axis=2)
    kinetic = (chain.mass * speed * error + chain.inertia * omega * (1.0 + omega)).sum(axis=1).max()
    gravity = np.linalg.norm(run.scene.gravity)
    potential = gravity * (chain.mass * (chain.size + np.cumsum(chain.length))).sum()
    supplied = np.abs(outputs["supplied"]).max()
    walls_and_springs = elastic_scale(run) + float(spring_moments(run).sum())
    return float(kinetic + potential + supplied + dissipated_scale(run) + walls_and_springs)


def spring_moments(run: Account) -> np.ndarray:
    """The largest moment of each joint's spring [N·m]: the energy that an error of 1 rad makes [J]."""
    links = run.scene.chain.links
    stiffness = np.array([link.joint_stiffness for link in links])
    if run.scene.chain.base == "free":
        stiffness[0] = 0.0
    rest = np.array([link.joint_rest_angle for link in links])
    angles = np.diff(run.outputs["angle"], axis=1, prepend=0.0) - rest
    return stiffness * np.abs(angles).max(axis=0)


def dissipated_scale(run: Account) -> float:
    """That of the dissipated energy [J], the energy itself and the kinetic one that contacts begin with."""
    sizes = np.abs(run.outputs["dissipated"]).max() + brought(run)
    return run.chain.energy + min(float(sizes), 2.0 * float(available(run).max()))


def available(run: Account) -> np.ndarray:
    """The energy that motion, walls and heat can have in each row [J]: that of the start and the supplied."""
    outputs = run.outputs
    return np.maximum(0.0, outputs["total"][0] + outputs["supplied"] - outputs["potential"])


def elastic_scale(run: Account) -> float:
    """The largest K δⁿ of the contacts times the scale of the penetration of each [J]."""
    impacts, law = run.impacts, run.laws_of_impacts
    if not len(impacts):
        return 0.0
    depth, (v0, foreseen) = impacts["max_penetration"], expected(run)
    chain = run.chain
    leeway = np.maximum(1.0, np.minimum(chain.size / law.unit / v0, 0.01 / run.scene.solver.tolerance))
    # but a clearance errs no more than the coordinates do
    error = np.minimum(np.maximum(depth, foreseen) * leeway, (chain.size + chain.length.sum()) / law.unit)
    return float((law.stiffness * np.maximum(depth, 0.0) ** law.exponent * error).max())


def expected(run: Account) -> tuple[np.ndarray, np.ndarray]:
    """v₀ [m/s] of each contact, and the depth δ* [m] with K δ*ⁿ⁺¹/(n+1) = ½ m v₀²; rigid ones have none."""
    law = run.laws_of_impacts
    v0, n = np.maximum(run.impacts["impact_speed"], law.slowest), law.exponent
    with np.errstate(divide="ignore"):
        depth = (0.5 * run.impacts["effective_mass"] * v0**2 * (n + 1) / law.stiffness) ** (1 / (n + 1))
    return v0, np.where(law.stiffness > 0.0, depth, 0.0)


def brought(run: Account) -> float:
    """The kinetic energy that the most violent contact began with, ½ m v₀² [J]."""
    v0 = np.maximum(run.impacts["impact_speed"], run.laws_of_impacts.slowest)
    return float((0.5 * run.impacts["effective_mass"] * v0**2).max(initial=0.0))


def round_off(run: Account) -> float:
    """What round-off changes in the ledger in a step [J]."""
    outputs = run.outputs
    terms = sum(
        np.abs(outputs[name]).max() for name in ("kinetic", "potential", "elastic", "dissipated", "supplied")
    )
    # sums of what may cancel
    far = np.abs(outputs["point_position"]).max()
    terms += run.chain.mass.sum() * np.linalg.norm(run.scene.gravity) * far
    if len(run.impacts):
        law = run.laws_of_impacts
        force = law.stiffness * np.maximum(0.0, run.impacts["max_penetration"]) ** law.exponent
        terms += (force * np.where(law.stop, 2.0 * np.abs(outputs["angle"]).max(), far)).max()
    terms += (spring_moments(run) * np.abs(outputs["angle"]).max(axis=0)).sum()
    return float(4.0 * EPSILON * terms)


def dissipation_bound(run: Account) -> float:
    """How far the dissipated energy may fall [J]: its true rate is ≥ 0, and its scale is in the norm."""
    return per_step(run, dissipated_scale(run))


# --- walls -------------------------------------------------------------------------------------------------


def containment(run: Account) -> Iterator[Row]:
    """Who is beyond a wall is in contact, and no deeper than the energy there is can push it."""
    every = run.laws
    if not every:
        return
    reach = run.chain.size + run.chain.length.sum()
    # a held point is put back to its wall after each step; in between it errs as its position does
    held = INTERPOLATED * run.scene.solver.tolerance * reach
    slack = np.array([(OUTSIDE + held * (law.stiffness == 0.0)) / law.unit for law in every])
    force, depth = by_candidate(run, "force"), by_candidate(run, "penetration")
    unseen = float((-clearances(run) - depth - left_inside(run) - slack).max())
    yield "outside", unseen, 0.0, "outside a wall, or beyond a stop, more than is reported [m, rad]"
    yield "pulls", float(-force.min()), 0.0, "a wall or a stop pulls [N, N·m]"
    energy = float(available(run).max()) + energy_bound(run)
    for c, law in enumerate(every):
        deepest = float(depth[:, c].max())
        if run.status == OK:  # else the contacts go on beyond the last row
            own = (run.impacts["point"] == law.point) & (run.impacts["wall"] == law.wall)
            deepest = max(deepest, float(run.impacts["max_penetration"][own].max(initial=0.0)))
        yield "too deep", deepest, depth_bound(run, law, energy), f"penetration of candidate {c} [m, rad]"


def left_inside(run: Account) -> np.ndarray:
    """How deep each candidate, in each row, may be after the end of its contact [m].

    A contact ends when its point will be out after LEFT of its time scale δ*/v₀.
    """
    depth = np.zeros_like(run.outputs["penetration"])
    column = {candidate: c for c, candidate in enumerate(candidates(run.scene))}
    v0, foreseen = expected(run)
    for row, speed, scale in zip(run.impacts, v0, foreseen, strict=True):
        since = run.time - row["end"]
        rows = (since >= 0.0) & (since <= SAFETY * LEFT * scale / speed)
        depth[rows, column[int(row["point"]), int(row["wall"])]] = LEFT * scale
    return depth


def clearances(run: Account) -> np.ndarray:
    """Clearance of each candidate in each row [m]; of a stop [rad]."""
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
    """The forces or penetrations of candidates in each row; those of joints belong to the nearer stop."""
    values, every = run.outputs[name].copy(), run.laws
    gaps = clearances(run)
    for c, law in enumerate(every):
        if law.stop and c > 0 and every[c - 1].stop and every[c - 1].point == law.point:
            # the first stop of a joint, joint_min, has what there is of both
            upper = gaps[:, c] < gaps[:, c - 1]
            values[:, c] = np.where(upper, values[:, c - 1], 0.0)
            values[:, c - 1] = np.where(upper, 0.0, values[:, c - 1])
        if name == "force" and run.scene.wall_names[law.wall] == "joint_max" and law.stop:
            values[:, c] *= -1.0
    return values


def depth_bound(run: Account, law: Law, energy: float) -> float:
    """DEEPER times the depth δ with K δⁿ⁺¹/(n+1) = all the energy that there was, plus a depth at rest.

    Energy: the total at the start, and what the inputs supplied, over the potential at the time. Rest: K δⁿ =
    weight + tip force, of a stop times the length of the chain, with the torques of the inputs and what the
    other joints' springs bear. Zero for a rigid wall.
    """
    if law.stiffness == 0.0:
        return 0.0
    n, k = law.exponent, law.stiffness
    force = run.chain.mass.sum() * np.linalg.norm(run.scene.gravity) + run.push
    if law.stop:
        force = force * run.chain.length.sum() + run.torque + spring_moments(run).sum()
    return float(DEEPER * ((energy * (n + 1) / k) ** (1 / (n + 1)) + (force / k) ** (1 / n)))


def speeds(run: Account) -> Iterator[Row]:
    """No contact begins with a point on its way from the wall, or ends with one on its way into it."""
    fastest = run.chain.size + float(np.linalg.norm(run.outputs["point_velocity"], axis=2).max())
    for name in ("impact_speed", "separation_speed"):
        known = run.impacts[name][~np.isnan(run.impacts[name])]
        least = float((known * run.laws_of_impacts.unit[~np.isnan(run.impacts[name])]).min(initial=0.0))
        yield f"negative {name}", -least, ROUND_OFF * fastest, f"{name} below zero by [m/s]"


def moments(run: Account) -> Iterator[Row]:
    """No contact begins before the start, ends before it begins, or after all."""
    onset, end = run.impacts["onset"], run.impacts["end"]
    last = run.scene.simulation.stop_time if run.status == OK else np.inf
    over = ~np.isnan(end)
    late = max(float(onset.max(initial=0.0)), float(end[over].max(initial=0.0))) - last
    yield "too late", late, 0.0, "a contact after the stop time [s]"
    yield "too early", -float(onset.min(initial=0.0)), 0.0, "a contact before the start [s]"
    backwards = float((onset - end)[over].max(initial=0.0))
    yield "backwards", backwards, 0.0, "a contact that ends before it begins [s]"


# --- friction ----------------------------------------------------------------------------------------------


def falls(scene: Scene, outputs: Any) -> Iterator[Row]:
    """That no impulse of a wall falls from one row to the next: kind, value, the most it may be, and what.

    It falls by no more than ten times the tolerance of its largest value, or round-off of a momentum.
    """
    mass, size = sum(link.mass for link in scene.chain.links), max(link.length for link in scene.chain.links)
    for c, (point, wall) in enumerate(candidates(scene)):
        if not scene.wall_names[wall].startswith("joint_"):  # those of a joint's two stops have signs
            impulse = outputs["impulse"][:, c]
            least = 10.0 * scene.solver.tolerance * float(np.abs(impulse).max()) + ROUND_OFF * mass * size
            fall = float((np.maximum.accumulate(impulse) - impulse).max())
            yield (
                "falls",
                fall,
                least,
                f"fall of the impulse of point {point} at {scene.wall_names[wall]} [N·s]",
            )


def friction_checks(scene: Scene, outputs: Any) -> Iterator[Row]:
    """What holds for friction at each row: kind, value, the most that it may be, and what that is."""
    if not scene.has_friction:
        return
    friction = outputs["friction"]
    size = max(link.length for link in scene.chain.links)
    mass = sum(link.mass for link in scene.chain.links)
    least = SMALL * mass * (np.hypot(*scene.gravity) + size) + state_errors(scene, outputs, size)
    excess = 0.0
    for c, (_, number) in enumerate(candidates(scene)):
        if number < len(scene.wall_names) and not scene.wall_names[number].startswith("joint_"):
            limit = _static(scene, scene.wall_names[number]) * np.maximum(outputs["force"][:, c], 0.0)
            excess = max(excess, float((np.abs(friction["force"][:, c]) - (1.0 + FORCE) * limit).max()))
    yield "cone", excess, least, "friction beyond its limit [N]"
    for i, link in enumerate(scene.chain.links):
        beyond = float(np.abs(friction["joint_moment"][:, i]).max()) - (1.0 + FORCE) * link.joint_friction
        yield (
            "joint friction",
            beyond,
            least * size,
            f"moment of friction in joint {i + 1} beyond its limit [N·m]",
        )
    shares = friction["sticking"] * (1.0 - friction["sticking"])
    yield "sticking", float(np.abs(shares).max(initial=0.0)), 0.0, "an output that is neither 0 nor 1"


def state_errors(scene: Scene, outputs: Any, size: float) -> float:
    """By how much forces at a row may be wrong [N], as the state that is interpolated there has errors.

    Those of positions, relative to a link length, of angles and of their rates are at most the tolerance:
    times the stiffness n F/δ of contacts, and that of springs and dampers in joints.
    """
    forces, depths = outputs["force"], outputs["penetration"]
    touching = depths > 0.0
    stiffness = (scene.contact.exponent or 1.0) * np.abs(forces[touching]) / depths[touching]
    joints = sum(link.joint_stiffness + link.joint_damping for link in scene.chain.links)
    return scene.solver.tolerance * (float(stiffness.max(initial=0.0)) * size + joints / size)


def _static(scene: Scene, name: str) -> float:
    """µ_s at a wall."""
    contact, own = scene.contact, scene.contact.wall.get(name)
    sliding, static = contact.friction, contact.static_friction
    if own is not None and own.friction is not None:
        sliding, static = own.friction, 0.0
    if own is not None and own.static_friction is not None:
        static = own.static_friction
    return max(sliding, static)
