"""The models: their reference results, checked by an integration that shares nothing with the kernel.

``python tests/test_models.py`` writes the reference results anew: every output of a model at a
tolerance of 1e-12, each 0.02 s, in models/<model>/reference.csv. Where a controller drives a model,
the inputs that it has set in a co-simulation are written before, to models/<model>/inputs.csv.
"""

import csv
import functools
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from chain_impact import load_scene, simulate
from chain_impact.results.recording import recording_of
from chain_impact.scene import SCENE_FILE, WALLS, model_names, models_folder
from chain_impact.variables import input_places

DOCS = Path(__file__).parents[1] / "docs" / "models"
STEP = 0.02  # s, between two rows of a reference
# until when [s] the two integrations are compared, and within what [m, rad, s]: the four-link chain
# amplifies an error of its start 2e4 times until 2 s; the rod comes to rest by ever more impacts
INDEPENDENT = {
    "controlled_arm": (0.34, 1e-9),
    "four_link_box": (2.0, 1e-6),
    "pinned_arm": (2.0, 1e-9),
    "ramp": (1.5, 1e-9),
    "rod_drop": (1.4, 1e-9),
}
# until the end, of positions [m] and angles [rad], and of their rates: during contact 1e-8 s are 1e-4 m/s
REGRESSION_ERROR = {
    "controlled_arm": (1e-7, 1e-6),
    "four_link_box": (1e-3, 1e-2),
    "pinned_arm": (1e-7, 1e-6),
    "ramp": (1e-6, 1e-5),
    "rod_drop": (1e-6, 1e-3),
}


CO_SIMULATED = {"controlled_arm": {"inputs.csv", "controller.py", "co_simulation.py", "masters.py"}}


def compute_reference(model):
    scene, inputs = load_scene(model), inputs_of(model)
    return recording_of(simulate(scene, output_step=STEP, tolerance=1e-12, method="explicit", inputs=inputs))


@functools.cache
def table(model, file):
    """The columns of one of the files of a model, and its time."""
    with (models_folder() / model / file).open(newline="") as lines:
        names, *rows = csv.reader(lines)
    columns = dict(zip(names, np.array(rows, dtype=float).T, strict=True))
    return columns.pop("time"), columns


def reference(model):
    """The columns of the stored reference, and its time."""
    return table(model, "reference.csv")


def inputs_of(model):
    """What drives a model, as ``simulate`` takes it."""
    if model not in CO_SIMULATED:
        return {}
    time, columns = table(model, "inputs.csv")
    return {name: (time, values) for name, values in columns.items()}


def coordinates(columns, links):
    """Positions and angles, and their rates, in two arrays (T, 2N + 2 + N)."""
    points = [f"point[{k}].{{}}{axis}" for k in range(links + 1) for axis in "xy"]
    turns = [f"link[{i}].{{}}" for i in range(1, links + 1)]
    values = [name.format("") for name in points] + [name.format("angle") for name in turns]
    rates = [name.format("v") for name in points] + [name.format("angular_velocity") for name in turns]
    return tuple(np.stack([columns[name] for name in names], axis=-1) for names in (values, rates))


# --- an independent integration: assembled mass matrix, scipy, terminal events -------------------------


class Chain:
    """The chain in the coordinates q = (x₀, y₀, θ), its contacts in a set of (point, wall)."""

    def __init__(self, scene, inputs):
        self.scene, self.links = scene, scene.chain.links
        # samples of the torques of all joints, which hold until the next
        torques = [inputs.get(f"joint[{i}].torque") for i in range(1, len(self.links) + 1)]
        self.samples = torques[-1][0] if inputs else np.zeros(1)
        self.torques = np.transpose([[0.0] if torque is None else torque[1] for torque in torques])
        self.count = len(self.links)
        self.free = slice(2 if scene.chain.base == "pinned" else 0, None)
        e = scene.contact.restitution
        # λ(1+e) = ln[(1+λ)/(1−λe)]
        self.factor = brentq(
            lambda x: x * (1 + e) - np.log((1 + x) / (1 - x * e)), 1e-6, (1 - 1e-15) / e, xtol=1e-15
        )
        # number, a point and the inward normal of each wall
        walls = []
        for w, name in enumerate(WALLS):
            axis, at = np.eye(2)[w // 2], getattr(scene.box, name)
            if at is not None:
                walls.append((w, tuple(at * axis), tuple((1 - 2 * (w % 2)) * axis)))
        for w, wall in enumerate(scene.walls, start=len(WALLS)):
            walls.append((w, wall.point, (-np.sin(wall.angle), np.cos(wall.angle))))
        self.candidates = [(k, *wall) for k in scene.contact.points for wall in walls]
        self.active = {}  # candidate → v0

    def place(self, y, link, part):
        """Jacobian of a point at a part of a link, and the acceleration at q̈ = 0."""
        jacobian, bias = np.zeros((2, 2 + self.count)), np.zeros(2)
        jacobian[:, :2] = np.eye(2)
        position = y[:2].copy()
        for j in range(link + 1):
            length = self.links[j].length * (part if j == link else 1.0)
            angle, omega = y[2 + j], y[self.count + 4 + j]
            along = length * np.array([np.cos(angle), np.sin(angle)])
            jacobian[:, 2 + j] = -along[1], along[0]
            bias -= omega**2 * along
            position += along
        return position, jacobian, bias

    def gap(self, y, candidate):
        """Clearance, its gradient and its rate."""
        point, _, at, normal = candidate
        position, jacobian, _ = self.place(y, point - 1, 1.0)
        gradient = normal @ jacobian
        clearance = normal @ (position - at) - self.scene.contact.radius
        return clearance, gradient, gradient @ y[self.count + 2 :]

    def rate(self, _time, y):
        n, contact = self.count, self.scene.contact
        mass, force = np.zeros((n + 2, n + 2)), np.zeros(n + 2)
        for i, link in enumerate(self.links):
            _, jacobian, bias = self.place(y, i, link.center_of_mass / link.length)
            mass += link.mass * jacobian.T @ jacobian
            mass[2 + i, 2 + i] += link.inertia
            force += link.mass * jacobian.T @ (np.array(self.scene.gravity) - bias)
            if i > 0 or self.free.start:
                torque = link.joint_damping * (y[n + 4 + i] - (y[n + 3 + i] if i else 0.0))
                torque -= self.torques[self.sample, i]
                force[2 + i] -= torque
                force[1 + i] += torque if i else 0.0
        for candidate, speed in self.active.items():
            gap, gradient, gap_rate = self.gap(y, candidate)
            depth = max(0.0, -gap)
            elastic = contact.stiffness * depth**contact.exponent
            force += gradient * elastic * max(0.0, 1 - self.factor * gap_rate / speed)
        acceleration = np.zeros(n + 2)
        acceleration[self.free] = np.linalg.solve(mass[self.free, self.free], force[self.free])
        return np.concatenate([y[n + 2 :], acceleration])

    def run(self, times):
        """The state at each of the times, and the onsets (time, point, wall, speed)."""
        initial = self.scene.initial
        y = np.array([*initial.position, *initial.angles, *initial.velocity, *initial.angular_velocities])
        states, onsets, now = np.zeros((len(times), len(y))), [], 0.0
        while now < times[-1]:
            events = [self.event(candidate) for candidate in self.candidates]
            longest = 5e-5 if self.active else 5e-3
            self.sample = np.searchsorted(self.samples, now, side="right") - 1
            changes = self.samples[self.sample + 1 :]
            done = solve_ivp(
                self.rate,
                (now, min([times[-1], *changes[:1]])),
                y,
                method="DOP853",
                rtol=1e-12,
                atol=1e-13,
                max_step=longest,
                events=events,
                dense_output=True,
            )
            inside = (times >= now) & (times <= done.t[-1])
            if inside.any():
                states[inside] = done.sol(times[inside]).T
            now, y = done.t[-1], done.y[:, -1]
            for candidate, found in zip(self.candidates, done.t_events, strict=True):
                if found.size and candidate in self.active:
                    del self.active[candidate]
                elif found.size:
                    self.active[candidate] = -self.gap(y, candidate)[2]
                    onsets.append((now, *candidate[:2], self.active[candidate]))
        return states, onsets

    def event(self, candidate):
        def clearance(_time, y):
            return self.gap(y, candidate)[0]

        clearance.terminal = True
        clearance.direction = 1 if candidate in self.active else -1
        return clearance


@pytest.mark.parametrize("model", model_names())
def test_the_reference_agrees_with_an_independent_integration(model):
    scene, (until, error) = load_scene(model), INDEPENDENT[model]
    time, columns = reference(model)
    chain, rows = Chain(scene, inputs_of(model)), time <= until + 1e-9
    states, onsets = chain.run(time[rows])

    n = chain.count
    values, rates = coordinates(columns, n)
    places = np.array([[chain.place(y, k - 1, 1.0)[0] for k in range(n + 1)] for y in states])
    assert places.reshape(len(states), -1) == pytest.approx(values[rows, : 2 * n + 2], abs=error)
    assert states[:, 2 : n + 2] == pytest.approx(values[rows, 2 * n + 2 :], abs=error)
    # the speeds change within some milliseconds
    assert states[:, n + 2 : n + 4] == pytest.approx(rates[rows, :2], abs=100 * error)
    assert states[:, n + 4 :] == pytest.approx(rates[rows, 2 * n + 2 :], abs=100 * error)

    inputs = inputs_of(model)
    found = simulate(scene, stop_time=until, tolerance=1e-12, method="explicit", inputs=inputs).impacts
    assert [(row["point"], row["wall"]) for row in found] == [(point, wall) for _, point, wall, _ in onsets]
    assert found["onset"] == pytest.approx([onset[0] for onset in onsets], abs=error)
    assert found["impact_speed"] == pytest.approx([onset[3] for onset in onsets], abs=100 * error)


@pytest.mark.parametrize("model", model_names())
def test_a_simulation_with_the_default_tolerance_agrees_with_the_reference(model):
    scene = load_scene(model)
    time, columns = reference(model)
    fresh = recording_of(simulate(scene, output_step=STEP, inputs=inputs_of(model)))
    assert list(fresh.columns) == list(columns)
    assert fresh.time == pytest.approx(time, abs=1e-12)
    links = len(scene.chain.links)
    found, expected = coordinates(fresh.columns, links), coordinates(columns, links)
    for now, then, error in zip(found, expected, REGRESSION_ERROR[model], strict=True):
        assert now == pytest.approx(then, abs=error)


@pytest.mark.parametrize("model", model_names())
def test_energy_is_conserved_in_the_reference(model):
    _, columns = reference(model)
    balance = columns["energy.total"] + columns["energy.dissipated"] - columns.get("energy.supplied", 0.0)
    assert balance == pytest.approx(balance[0], abs=1e-9)


def test_every_model_has_its_files():
    for model in model_names():
        files = {file.name for file in (models_folder() / model).iterdir() if file.is_file()}
        assert files == {SCENE_FILE, "reference.csv"} | CO_SIMULATED.get(model, set())
        assert (DOCS / f"{model}.md").is_file()


def write_inputs(model):
    """Co-simulate a model, and keep the inputs that its controller has set."""
    folder = models_folder() / model
    with tempfile.TemporaryDirectory() as scratch:
        subprocess.run([sys.executable, folder / "co_simulation.py", "-o", scratch], check=True)
        with Path(scratch, "ControlledArm.csv").open(newline="") as file:
            rows = list(csv.reader(file))
    chosen = [rows[0].index(name) for name in ("time", *input_places(load_scene(model)))]
    with (folder / "inputs.csv").open("w", newline="") as file:
        csv.writer(file).writerows([row[column] for column in chosen] for row in rows)


if __name__ == "__main__":
    for name in CO_SIMULATED:
        write_inputs(name)
    for name in model_names():
        compute_reference(name).save_csv(models_folder() / name / "reference.csv")
