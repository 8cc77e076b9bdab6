"""MuJoCo with dry friction: ``python -m benchmarks friction [--quick]``.

A rod rests on a slope by friction: how fast does it creep, and how much CPU time does a run take? Two links
are thrown onto a floor with friction: the error of the state, in motion and at rest, over the CPU time.
MuJoCo's contact differs from ours, so each program is judged by its own converged run. Without damping,
MuJoCo's integrators Euler, implicit and implicitfast are the same, so only Euler and RK4 are used.

In MuJoCo a chain has slides and hinges in the x–z plane, with relative angles; points that may touch are
small spheres, walls are planes set back by their radius. The chain can also slide along y, though nothing
moves it there: MuJoCo's friction at a point has two directions, and ``noslip_iterations`` have no effect on a
contact that cannot move in both directions.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks import common
from benchmarks.looks import LIGHT_BLUE, OUR_COLOUR, WIDTH, name_curves, strong
from benchmarks.peers.ours import Kernel
from benchmarks.race import ROUNDS, Entries, above_loosest, race, seconds_at
from chain_impact import simulate
from chain_impact.pictures.drawing.colours import BLUE, GREEN, INK, PURPLE
from chain_impact.pictures.drawing.dark_ground import ORANGE, PLUM
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.scene import Scene
from chain_impact.text import number_text
from tests.helpers.scenes.friction import SLOPE, sled, thrown

TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
FINE, FINEST = 1e-12, 1e-6  # tolerance, and step of MuJoCo [s], of runs that count as exact
# [s] on the slope: the time from which the drift counts, the end of a run, the end of a long run
SETTLED, STOP, HOUR = 10.0, 60.0, 3600.0
SLOPE_STEPS = (1e-2, 1e-3)  # [s] MuJoCo's steps
AT_REST = {"contact.friction": 0.6, "initial.vx": 0.0, "initial.vy": 0.0}
TIMES = {"moving": 0.3, "resting": 1.5}  # [s] at which the state of the thrown chain is judged
THROWN_STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)  # [s] MuJoCo's steps
PATIENCE = 60.0  # [s] a run that takes longer is timed twice only
UNSTABLE = 10.0  # [m, rad, m/s or rad/s] a run with a larger error is left out
RADIUS = 1e-6  # [m] of MuJoCo's spheres: friction acts at the surface of a sphere and not at its centre
# MJCF of spheres and of walls: spheres collide with walls only
BALL, WALL = (f'contype="{a}" conaffinity="{1 - a}"' for a in (1, 0))


# --- a scene in MuJoCo ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Contact:
    """MuJoCo's model of contacts and friction; the defaults are MuJoCo's own except for the elliptic cones.

    Attributes:
        solref: time constant [s] and damping ratio.
        solimp: least and largest impedance, and the penetration [m] at which the largest is reached.
        impratio: hardness of friction, relative to the hardness of the contact along its normal.
        noslip: number of iterations of the solver that removes slip afterwards.
        refsafe: whether time constants below two steps are raised to two steps.
    """

    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, float, float] = (0.9, 0.95, 0.001)
    impratio: float = 1.0
    noslip: int = 0
    refsafe: bool = True


DEFAULTS = Contact()
NOSLIP = replace(DEFAULTS, noslip=10)


def _planes(scene: Scene) -> str:
    """Return the walls; the normal of a plane is its z axis."""
    planes = ""
    for name, wall in scene.half_planes.items():
        (nx, nz), back = wall.normal, wall.offset - RADIUS
        wall_friction = scene.contact.wall[name].friction
        friction = scene.contact.friction if wall_friction is None else wall_friction
        turn = math.degrees(math.atan2(nx, nz))
        place = f'pos="{nx * back} 0 {nz * back}" axisangle="0 1 0 {turn}"'
        planes += f'<geom type="plane" size="9 9 1" {place} friction="{friction} 0 0" {WALL}/>'
    return planes


def _bodies(scene: Scene) -> str:
    """Return the links, each inside the one before."""
    links, points = scene.chain.links, {point for point, _ in candidates_of(scene)}

    def ball(point: int, x: float) -> str:
        if point not in points:
            return ""
        return f'<geom type="sphere" size="{RADIUS}" pos="{x} 0 0" friction="0 0 0" {BALL} mass="0"/>'

    body_text = ball(len(links), links[-1].length)
    for i in range(len(links) - 1, -1, -1):
        link = links[i]
        slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 0 1", "0 1 0"))
        dry = f'frictionloss="{link.joint_friction}"' if i and link.joint_friction else ""
        place = f"{links[i - 1].length} 0 0" if i else "0 0 0"
        inertia = " ".join([str(link.inertia)] * 3)
        body_text = (
            f'<body pos="{place}">{"" if i else slides}<joint type="hinge" axis="0 -1 0" {dry}/>'
            f'<inertial pos="{link.center_of_mass} 0 0" mass="{link.mass}" diaginertia="{inertia}"/>'
            f"{ball(i, 0.0)}{body_text}</body>"
        )
    return body_text


def model_text(scene: Scene, integrator: str, dt: float, contact: Contact) -> str:
    """Return the model as MJCF."""
    ref, imp = (" ".join(map(str, values)) for values in (contact.solref, contact.solimp))
    gx, gy = scene.gravity
    return f"""<mujoco><compiler angle="degree" inertiafromgeom="false" boundmass="0"/>
<option timestep="{dt}" integrator="{integrator}" gravity="{gx} 0 {gy}" iterations="50" tolerance="1e-12"
 cone="elliptic" impratio="{contact.impratio}" noslip_iterations="{contact.noslip}">
<flag refsafe="{"enable" if contact.refsafe else "disable"}"/></option>
<default><geom condim="3" solref="{ref}" solimp="{imp}"/>
<joint solreffriction="{ref}" solimpfriction="{imp}"/></default>
<worldbody>{_planes(scene)}{_bodies(scene)}</worldbody></mujoco>"""


class Engine:
    """One model, which is reset to the start for each run."""

    def __init__(self, scene: Scene, integrator: str, dt: float, contact: Contact) -> None:
        import mujoco  # the chart does not need mujoco

        self.mujoco = mujoco
        self.first, self.dt = scene.initial, dt
        self.model = mujoco.MjModel.from_xml_string(model_text(scene, integrator, dt, contact))
        self.data = mujoco.MjData(self.model)
        self.plane = np.delete(np.arange(self.model.nq), 2)  # all coordinates except the slide along y

    def run(self, stop: float) -> None:
        """Run from the start to ``stop`` [s]."""
        self.mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self.plane] = [*self.first.position, *np.diff([0.0, *self.first.angles])]
        self.data.qvel[self.plane] = [*self.first.velocity, *np.diff([0.0, *self.first.angular_velocities])]
        self.mujoco.mj_step(self.model, self.data, nstep=round(stop / self.dt))

    def state(self, stop: float) -> np.ndarray:
        """Return the state at ``stop`` [s] in the kernel's form: x₀, y₀, angles, and their rates."""
        self.run(stop)
        q, v = self.data.qpos[self.plane], self.data.qvel[self.plane]
        return np.concatenate([q[:2], np.cumsum(q[2:]), v[:2], np.cumsum(v[2:])])

    @property
    def unstable(self) -> bool:
        """Whether numbers have overflowed in the run, so that MuJoCo has reset it."""
        return any(warning.number for warning in self.data.warning)


# --- a rod at rest on a slope -----------------------------------------------------------------------------


def drift(early: np.ndarray, late: np.ndarray, stop: float) -> dict[str, float]:
    """Return ``drift``: the mean speed along the slope [µm/s] between states at SETTLED and at ``stop``."""
    distance = (late - early)[:2] @ (math.cos(SLOPE), -math.sin(SLOPE))
    return {"drift": common.rounded(1e6 * abs(distance) / (stop - SETTLED))}


def stiffest(dt: float) -> Contact:
    """Return the least time constant and the largest impedance that MuJoCo accepts, and hard friction."""
    return Contact((2.0 * dt, 1.0), (0.9999, 0.9999, 0.001), impratio=100.0)


ON_THE_SLOPE: dict[str, Callable[[float], Contact]] = {
    "defaults": lambda _: DEFAULTS,
    "defaults, impratio 100": lambda _: replace(DEFAULTS, impratio=100.0),
    "stiffest, impratio 100": stiffest,
    "defaults, noslip": lambda _: NOSLIP,
}
"""MuJoCo's settings: name → the contact at a step [s]."""


def at_rest() -> Entries:
    """Return results of our kernel at some tolerances, also after an hour, and of MuJoCo's settings."""
    entries: dict[tuple[str, float], Any] = {}
    for name, stop in (("ours", STOP), ("ours, an hour", HOUR)):
        for tolerance in TOLERANCES:
            scene = sled(**AT_REST | {"solver.tolerance": tolerance})
            early, kernel = Kernel(scene, SETTLED).outcome(), Kernel(scene, stop)
            late = kernel.outcome()
            figures = {"failed": late.failed} if late.failed else drift(early.state, late.state, stop)
            entries[name, tolerance] = kernel.run, figures
    for integrator in ("Euler", "RK4"):
        for name, contact in ON_THE_SLOPE.items():
            for dt in SLOPE_STEPS:
                engine = Engine(sled(**AT_REST), integrator, dt, contact(dt))
                figures = drift(engine.state(SETTLED), engine.state(STOP), STOP)
                entries[f"MuJoCo {integrator}, {name}", dt] = partial(engine.run, STOP), figures
    return entries


# --- a thrown chain ---------------------------------------------------------------------------------------


def duration_of_ours() -> Contact:
    """Return a linear contact with the duration of our first impact.

    Its rebound would be that of our impact if the contact could pull.
    """
    scene = thrown(**{"solver.tolerance": 1e-10})
    first, slope = simulate(scene).impacts[0], math.log(scene.contact.restitution)
    ratio, duration = -slope / math.hypot(math.pi, slope), float(first["end"] - first["onset"])
    constant = duration * math.sqrt(1.0 - ratio**2) / (math.pi * ratio)
    return Contact((constant, ratio), (0.99, 0.99, 0.001), refsafe=False)


def throw(stop: float, rounds: int) -> list[dict[str, Any]]:
    """Return the errors at ``stop`` [s] against each program's own converged run, and the CPU times."""
    entries: dict[tuple[str, float], Any] = {}
    scenes = {tolerance: thrown(**{"solver.tolerance": tolerance}) for tolerance in (FINE, *TOLERANCES)}
    expected = Kernel(scenes[FINE], stop).outcome().state
    for tolerance in TOLERANCES:
        kernel = Kernel(scenes[tolerance], stop)
        entries["ours", tolerance] = kernel.run, {"error": largest_error(kernel.outcome().state, expected)}
    contacts = {"defaults": DEFAULTS, "defaults, noslip": NOSLIP, "duration of ours": duration_of_ours()}
    for integrator in ("Euler", "RK4"):
        for name, contact in contacts.items():
            expected = Engine(thrown(), integrator, FINEST, contact).state(stop)
            for dt in THROWN_STEPS:
                engine = Engine(thrown(), integrator, dt, contact)
                error = largest_error(engine.state(stop), expected)
                if not engine.unstable and error < UNSTABLE:
                    entries[f"MuJoCo {integrator}, {name}", dt] = partial(engine.run, stop), {"error": error}
    rows = race(entries, "ours", rounds, PATIENCE)
    our_rows = [row for row in rows if row["name"] == "ours"]
    for row in rows:
        equal = seconds_at(row["error"], our_rows, "error")
        row["times ours"] = equal and common.rounded(row["seconds"]["median"] / equal, 3)
    return rows


def largest_error(state: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest error of a component (m, rad, m/s, rad/s)."""
    return common.rounded(np.abs(state - expected).max())


# --- the chart ----------------------------------------------------------------------------------------------

SIZE = (WIDTH, 4.4)  # [inch] of the chart
LOWEST_DRIFT = 1e-6  # [µm/s] smaller drifts are drawn here, at "none"
BREAK = 1e-5  # [µm/s] place of the line between "none" and the logarithmic scale
CREEPS, HEADLINE_STEP = "MuJoCo Euler, defaults", 1e-3  # the setting and the step [s] of the headline
NOSLIP_NAME = "MuJoCo Euler, defaults, noslip"
LOOKS = {
    "ours": (OUR_COLOUR, "o"),
    CREEPS: (BLUE, "s"),
    NOSLIP_NAME: (GREEN, "v"),
    "MuJoCo Euler, defaults, impratio 100": (PLUM, "^"),
    "MuJoCo Euler, stiffest, impratio 100": (INK, "D"),
    "MuJoCo Euler, duration of ours": (PURPLE, "P"),
    "MuJoCo RK4, defaults": (LIGHT_BLUE, "X", "--"),
    "MuJoCo RK4, duration of ours": (ORANGE, "*", "--"),
}
"""Colour, mark and line of each setting: RK4 has dashes."""


def draw(figure: Any, record: Any) -> None:
    """Draw drift and errors against CPU time."""
    results, panels = record["results"], figure.subplots(1, 3)
    for axes, (key, rows) in zip(panels, results.items(), strict=True):
        value = "drift" if key == "slope" else "error"
        for name, look in LOOKS.items():
            if key != "slope" and name == NOSLIP_NAME:
                continue  # its errors are those of the defaults
            named_rows = [row for row in rows if row["name"] == name and "seconds" in row]
            times = [1e3 * row["seconds"]["median"] for row in named_rows]
            values = [max(row[value], LOWEST_DRIFT) if key == "slope" else row[value] for row in named_rows]
            label = {"ours": "chain-impact"}.get(name, name.removeprefix("MuJoCo "))
            label = label.replace("duration of ours", "our duration")
            axes.loglog(times, values, label=label, **strong(name == "ours", *look))
        axes.set_xlabel("CPU time [ms]")
        axes.set_title(f"thrown chain, {key}" if key != "slope" else f"rod on a slope, {STOP:g} s")
        axes.minorticks_off()
    panels[0].set_ylabel("drift [µm/s]")
    panels[1].set_ylabel("largest error [m, rad, m/s or rad/s]")
    panels[2].sharey(panels[1])
    panels[2].tick_params(labelleft=False)
    panels[0].set_yticks(
        [LOWEST_DRIFT, 1e-4, 1e-2, 1.0, 1e2, 1e4], ["none", *(f"$10^{{{k}}}$" for k in (-4, -2, 0, 2, 4))]
    )
    write_headline(figure, *headline(results))
    # below the lowest decade that is drawn, the axis is broken: "none" is not on the logarithmic scale
    panels[0].axhline(BREAK, color=INK, linewidth=0.8, linestyle=(0.0, (1.0, 3.0)))
    name_curves(figure, panels)


def headline(results: dict[str, list[dict[str, Any]]]) -> tuple[str, str]:
    """Return the title and the text below it: drift, CPU time over ours, and error over ours.

    If even our loosest run has a smaller error than MuJoCo's, the factor of the time is a lower bound.
    """
    creep = next(row["drift"] for row in results["slope"] if row["name"] == CREEPS)
    factors, errors = [], []
    for key in TIMES:
        our_rows = [row for row in results[key] if row["name"] == "ours"]
        for row in results[key]:
            if (row["name"], row["setting"]) == (CREEPS, HEADLINE_STEP) and row["times ours"]:
                factors.append(row["times ours"])
                errors.append(above_loosest(row["error"], our_rows, "error"))
    time_text, error_text = (f"{min(values):.2g} to {max(values):.2g} times" for values in (factors, errors))
    return (
        f"chain-impact holds a rod on a slope, on which MuJoCo's defaults drift {creep / 1e3:.2g} mm/s",
        "Euler, RK4: MuJoCo, also with the duration of our contacts; noslip holds the rod, too  ·  "
        f"none: below {number_text(BREAK)} µm/s  ·  defaults, "
        f"thrown chain: {time_text} the CPU time of our loosest run, and {error_text} the error, "
        f"with steps of {1e3 * HEADLINE_STEP:g} ms",
    )


def main() -> None:
    """Measure and draw."""
    rounds = common.rounds(__doc__, ROUNDS)
    common.needed("mujoco")
    started = common.environment(("mujoco",))
    results = {"slope": race(at_rest(), "ours", rounds, PATIENCE)}
    results |= {key: throw(stop, rounds) for key, stop in TIMES.items()}
    settings = {
        "rounds": rounds, "slope [rad]": SLOPE, "friction at the slope": AT_REST["contact.friction"],
        "drift from [s]": SETTLED, "to [s]": STOP, "thrown, until [s]": TIMES, "converged step [s]": FINEST,
        "converged tolerance": FINE, "duration of ours": str(duration_of_ours()), "defaults": str(DEFAULTS),
    }  # fmt: skip
    common.save("friction", started, settings, results)
    common.picture("friction", draw, SIZE)


if __name__ == "__main__":
    main()
