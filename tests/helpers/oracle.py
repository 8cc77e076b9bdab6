"""The checks of the random search: rules from the laws of physics and the docs that hold for every run.

The checks need no exact solution. Each check compares a value with a bound that docs/computation.md promises:
the errors of a step are within the tolerance times scales of the model. ``judge`` takes the results of a run
(``Account``) and returns ``Finding``s with numbers; ``search.verdict`` runs a scene in a separate process
with a time limit, so that a hang is a finding (tests/helpers/search.py).
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

CPU = 2.0  # [s] CPU time that a run may take
ROWS = 50  # number of communication points, in addition to the start
SAFETY = 3.0  # factor on the tolerance, because the error control uses estimates, and scales are sampled
INTERPOLATED = 10.0  # error of an output between steps, over the error of a step
OUTSIDE = 1e-9  # [m] largest distance of a point beyond a wall that is not reported as a penetration
DEEPER = 3.0  # largest depth, over the depth that the available energy can reach
# time after the end of a contact for which its point may be inside the wall, over the contact's time scale
LEFT = 0.01
ROUND_OFF = 1e-12  # largest speed of unknown sign, over the speeds of the chain and a link length per second
FORCE = 1e-9  # largest excess of friction that is round-off, over the limit of friction
SMALL = 1e-8  # over the weight of the chain, and over its mass times one link length per second squared
EPSILON = 2.0**-52
Row = tuple[str, float, float, str]  # a row of a check: kind, value, bound, and words for the bound


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
    """Return the laws of contacts as columns."""
    by_candidate = {(law.point, law.wall): law for law in every}
    rows = [by_candidate[int(row["point"]), int(row["wall"])] for row in impacts]
    names = ("stiffness", "exponent", "slowest", "unit", "stop")
    return SimpleNamespace(**{name: np.array([getattr(row, name) for row in rows]) for name in names})


@dataclass(frozen=True)
class Columns:
    """The data of a chain's links, as columns."""

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
    """Run a scene in this process, with its record in ``memory`` if given, so that others can read it."""
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
    """Return the largest allowed drift of the energy balance [J].

    The exact motion conserves the energy balance, from any state. So the drift is the sum of the changes by
    errors of the steps, and nothing amplifies these changes. The error of one step may be the tolerance times
    a scale for each component of the state (docs/computation.md, error norm); ``energy_scale`` is the
    resulting change of the balance, to first order. The errors of n steps add up like √n, because they have
    no common sign. An output between steps is interpolated, with an error up to ten times as large. SAFETY
    covers two facts: the solver uses an estimate of a step's error, and the scale is sampled only at some
    points. The largest drift in the scenes of 2000 seeds was √n/2 times tolerance and scale.

    Round-off is added: a few units in the last place of the energies and, at stiff walls, of the positions,
    because a force F turns an error of a position into an error of energy.
    """
    return per_step(run, energy_scale(run))


def per_step(run: Account, scale: float) -> float:
    """Return the energy change [J] that round-off and allowed errors cause in all steps of a run.

    An allowed error is the tolerance times a scale [J].
    """
    steps = max(1.0, float(run.statistics["steps"]))
    errors = SAFETY * max(INTERPOLATED, steps**0.5) * run.scene.solver.tolerance * scale
    return float(errors + steps * round_off(run))


def energy_scale(run: Account) -> float:
    """Return a bound [J] on the change of the energy balance by an error of one, in units of the error norm.

    Kinetic: with |δv₀| ≤ s/1s + |v₀| and |δω| ≤ 1 rad/s + |ω|, Σ m |v_C| |δv_C| + I |ω| |δω|. Potential: with
    |δx₀| ≤ s and |δθ| ≤ 1 rad, Σ m |g| |δx_C|. Dissipated: its scale in the norm. Elastic: F |δg| with the
    scale of the penetration, and k |φ| |δφ| with |δφ| ≤ 1 rad. The supplied energy is not controlled: its
    absolute value counts.

    A motion with more energy than is available counts with the available energy, so that an explosion does
    not increase its own bound.
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
    """Return the largest moment of each joint's spring [N·m], which is the energy for an error of 1 rad."""
    links = run.scene.chain.links
    stiffness = np.array([link.joint_stiffness for link in links])
    if run.scene.chain.base == "free":
        stiffness[0] = 0.0
    rest = np.array([link.joint_rest_angle for link in links])
    angles = np.diff(run.outputs["angle"], axis=1, prepend=0.0) - rest
    return stiffness * np.abs(angles).max(axis=0)


def dissipated_scale(run: Account) -> float:
    """Return the scale of the dissipated energy [J]: this energy plus the kinetic energy at onsets."""
    sizes = np.abs(run.outputs["dissipated"]).max() + brought(run)
    return run.chain.energy + min(float(sizes), 2.0 * float(available(run).max()))


def available(run: Account) -> np.ndarray:
    """Return the energy [J] that motion, walls and heat can have in each row: at the start plus supplied."""
    outputs = run.outputs
    return np.maximum(0.0, outputs["total"][0] + outputs["supplied"] - outputs["potential"])


def elastic_scale(run: Account) -> float:
    """Return the sum of the contacts' largest K δⁿ times the scale of their penetrations [J]."""
    impacts, law = run.impacts, run.laws_of_impacts
    if not len(impacts):
        return 0.0
    depth, (v0, foreseen) = impacts["max_penetration"], expected(run)
    chain = run.chain
    leeway = np.maximum(1.0, np.minimum(chain.size / law.unit / v0, 0.01 / run.scene.solver.tolerance))
    # the error of a clearance is at most the error of the coordinates
    error = np.minimum(np.maximum(depth, foreseen) * leeway, (chain.size + chain.length.sum()) / law.unit)
    return float((law.stiffness * np.maximum(depth, 0.0) ** law.exponent * error).max())


def expected(run: Account) -> tuple[np.ndarray, np.ndarray]:
    """Return v₀ [m/s] of each contact, and the depth δ* [m] with K δ*ⁿ⁺¹/(n+1) = ½ m v₀².

    Both are 0 for a rigid contact.
    """
    law = run.laws_of_impacts
    v0, n = np.maximum(run.impacts["impact_speed"], law.slowest), law.exponent
    with np.errstate(divide="ignore"):
        depth = (0.5 * run.impacts["effective_mass"] * v0**2 * (n + 1) / law.stiffness) ** (1 / (n + 1))
    return v0, np.where(law.stiffness > 0.0, depth, 0.0)


def brought(run: Account) -> float:
    """Return the largest kinetic energy with which a contact began, ½ m v₀² [J]."""
    v0 = np.maximum(run.impacts["impact_speed"], run.laws_of_impacts.slowest)
    return float((0.5 * run.impacts["effective_mass"] * v0**2).max(initial=0.0))


def round_off(run: Account) -> float:
    """Return the change of the energy balance by round-off in a step [J]."""
    outputs = run.outputs
    terms = sum(
        np.abs(outputs[name]).max() for name in ("kinetic", "potential", "elastic", "dissipated", "supplied")
    )
    # sums of terms that may cancel
    far = np.abs(outputs["point_position"]).max()
    terms += run.chain.mass.sum() * np.linalg.norm(run.scene.gravity) * far
    if len(run.impacts):
        law = run.laws_of_impacts
        force = law.stiffness * np.maximum(0.0, run.impacts["max_penetration"]) ** law.exponent
        terms += (force * np.where(law.stop, 2.0 * np.abs(outputs["angle"]).max(), far)).max()
    terms += (spring_moments(run) * np.abs(outputs["angle"]).max(axis=0)).sum()
    return float(4.0 * EPSILON * terms)


def dissipation_bound(run: Account) -> float:
    """Return the largest allowed decrease of the dissipated energy [J]: the true rate is ≥ 0."""
    return per_step(run, dissipated_scale(run))


# --- walls -------------------------------------------------------------------------------------------------


def containment(run: Account) -> Iterator[Row]:
    """Check that every point beyond a wall is in contact. The energy of the chain bounds its penetration."""
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
    """Return how deep each candidate, in each row, may be after the end of its contact [m].

    A contact ends when its point will leave the wall within LEFT of the time scale δ*/v₀.
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
    """Return DEEPER times the depth δ with K δⁿ⁺¹/(n+1) = all energy so far, plus the depth at rest.

    The energy is the total at the start plus the supplied energy, minus the present potential energy. At
    rest, K δⁿ = weight + tip force; for a stop, this force times the length of the chain, plus the torques of
    the inputs and of the other joints' springs. The result is 0 for a rigid wall.
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
        known = run.impacts[name][~np.isnan(run.impacts[name])]
        least = float((known * run.laws_of_impacts.unit[~np.isnan(run.impacts[name])]).min(initial=0.0))
        yield f"negative {name}", -least, ROUND_OFF * fastest, f"{name} below zero by [m/s]"


def moments(run: Account) -> Iterator[Row]:
    """Check that contacts begin after the start, end after they begin, and not after the end of the run."""
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
    """Check that no impulse of a wall falls between rows; return kind, value, bound and words.

    An impulse may fall by ten times the tolerance of its largest value, or by round-off of a momentum.
    """
    mass, size = sum(link.mass for link in scene.chain.links), max(link.length for link in scene.chain.links)
    for c, (point, wall) in enumerate(candidates(scene)):
        if not scene.wall_names[wall].startswith("joint_"):  # impulses of a joint's two stops have signs
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
    """Return checks of friction at each row: kind, value, bound and words."""
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
    """Return the possible errors of forces at a row [N], because the interpolated state has errors.

    The errors of positions, over a link length, of angles and of their rates are at most the tolerance. These
    errors are multiplied by the stiffness n F/δ of contacts, and by that of springs and dampers in joints.
    """
    forces, depths = outputs["force"], outputs["penetration"]
    touching = depths > 0.0
    stiffness = (scene.contact.exponent or 1.0) * np.abs(forces[touching]) / depths[touching]
    joints = sum(link.joint_stiffness + link.joint_damping for link in scene.chain.links)
    return scene.solver.tolerance * (float(stiffness.max(initial=0.0)) * size + joints / size)


def _static(scene: Scene, name: str) -> float:
    """Return µ_s at a wall."""
    contact, own = scene.contact, scene.contact.wall.get(name)
    sliding, static = contact.friction, contact.static_friction
    if own is not None and own.friction is not None:
        sliding, static = own.friction, 0.0
    if own is not None and own.static_friction is not None:
        static = own.static_friction
    return max(sliding, static)
