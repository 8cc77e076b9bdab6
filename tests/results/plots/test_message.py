"""The headline of a picture says what happened, in numbers that are those of the recording."""

import re
from dataclasses import replace

import numpy as np
import pytest

from chain_impact import Recording, load_scene, simulate
from chain_impact.results.plots.message import conditions, message
from chain_impact.scene.scene import with_values
from tests.results.plots.pictures import MODELS, hit, recorded, swing
from tests.stops import knee


@pytest.mark.parametrize("model", MODELS)
def test_the_numbers_are_those_of_the_recording(model):
    recording = recorded(model)
    said = message(recording)
    assert said.startswith(recording.name + ": ")
    assert int(re.search(r"(\d+) impact", said)[1]) == recording.impact_count
    assert said.endswith(f" in {recording.time[-1]:g} s")
    columns = recording.columns
    if share := re.search(r"([\d.]+) % of the energy", said):
        before, after = columns["energy.total"][[0, -1]]
        # without inputs, what is not left was dissipated
        lost = 100 * (1 - after / before)
        assert float(share[1]) == pytest.approx(lost, abs=0.6 if lost > 1 else 0.06 * lost)
    elif found := re.search(r"([\d.]+) J dissipated", said):
        assert float(found[1]) == pytest.approx(columns["energy.dissipated"][-1], rel=5e-3)
    else:  # an elastic wall takes nothing
        assert abs(columns["energy.dissipated"]).max() < 1e-9


def test_a_share_is_said_only_where_it_means_something():
    hits = [hit(1.0, 1, "y_max", 1.0)]
    assert "1 impact, 50 % of the energy dissipated in 2 s" in message(swing(hits, {"y_max": 1.0}))
    below = swing(hits, {"y_max": 1.0})
    below.columns["energy.potential"] = np.linspace(1.0, -1.0, 50)  # which has no natural zero
    assert "1 impact, 1 J dissipated in 2 s" in message(below)
    driven = swing(hits, {"y_max": 1.0})
    driven.columns["energy.supplied"] = np.ones(50)
    assert "1 J dissipated" in message(driven)


def test_impacts_alone_dissipate_where_no_joint_is_damped():
    hits, walls = [hit(1.0, 1, "y_max", 1.0)], {"y_max": 1.0}
    free, damped = ({"link[1].joint_damping": value} for value in (0.0, 0.1))
    assert "1 impact dissipates 50 %" in message(swing(hits, walls, parameters=free))
    assert "2 impacts dissipate 50 %" in message(swing(hits * 2, walls, parameters=free))
    assert "1 impact, 50 %" in message(swing(hits, walls, parameters=damped))
    assert "no impacts, 50 %" in message(swing(parameters=free))


def test_nothing_is_said_of_energy_that_is_not_lost_or_not_known():
    recording = swing()
    recording.columns["energy.dissipated"] = np.zeros(50)
    assert message(recording) == "Swing: no impacts in 2 s"
    recording = swing()
    del recording.columns["energy.dissipated"]
    assert message(recording) == "Swing: no impacts in 2 s"


def test_the_conditions_are_the_parameters_of_the_run():
    changes = {
        ("contact", "stiffness"): 2.145e10,
        ("contact", "model"): "flores",
        ("solver", "tolerance"): 1e-6,
    }
    scene = with_values(load_scene("rod_drop"), changes | {("simulation", "stop_time"): 0.1})
    assert conditions(simulate(scene)).split("  ·  ") == [
        "1 link",
        "law flores",
        "restitution e = 0.7",
        "stiffness K = 2.145e10 N/m$^{1.5}$",
        "method auto, tolerance 1e-6",
    ]
    assert "joint damping ≤ 0.02 N·m·s/rad" in conditions(recorded("pinned_arm"))
    assert "radius 0.05 m" in conditions(recorded("ramp"))


def test_an_impulse_has_no_stiffness():
    known = recorded("rod_drop").parameters | {"contact.model": "newton_impact"}
    assert "stiffness" not in conditions(swing(parameters=known))


def test_without_parameters_only_the_links_are_known():
    assert conditions(swing()) == "1 link"


@pytest.mark.parametrize(
    ("walls", "own", "told"),
    [
        ("zhang_sharf", None, "stops e = 0.5, K = 1e4 N·m/rad$^{1.5}$"),
        ("newton_impact", None, "stops e = 0.5"),
        ("zhang_sharf", "newton_impact", "stops law newton_impact, e = 0.5"),
        ("newton_impact", "flores", "stops law flores, e = 0.5, K = 1e4 N·m/rad$^{1.5}$"),
        ("flores", "flores", "stops law flores, e = 0.5, K = 1e4 N·m/rad$^{1.5}$"),
    ],
)
def test_rigid_stops_have_no_stiffness(walls, own, told):
    scene = knee(**{"contact.model": walls}, **({"stops.model": own} if own else {}))
    parts = conditions(simulate(scene, 0.5)).split("  ·  ")
    assert told in parts
    assert ("stiffness K = 1e8 N/m$^{1.5}$" in parts) == (walls != "newton_impact")


FORCE = "stops e = 0.5, K = 1e4 N·m/rad$^{1.5}$"


@pytest.mark.parametrize(
    ("values", "time", "told"),
    [
        ({"stops.model": "newton_impact"}, 0.5, "stops e = 0.5"),
        ({"contact.model": "newton_impact", "stops.model": "flores"}, 0.5, FORCE),
        # without an impact at a stop, only the law of the walls is known
        ({"contact.model": "newton_impact", "stops.model": "flores"}, 0.1, "stops e = 0.5"),
        ({"contact.model": "zhang_sharf", "stops.model": "newton_impact"}, 0.1, FORCE),
    ],
)
def test_the_rigid_stops_of_an_fmu_are_known_by_their_impacts(values, time, told):
    """Its parameters do not tell that the stops have a law of their own."""
    recording = simulate(knee(**values), time)
    assert recording.at_stops.any() == (time > 0.1)
    vars(recording)["stop_law"] = ""
    assert told in conditions(recording).split("  ·  ")


def test_a_force_at_a_rigid_stop_that_holds_a_joint_is_no_sign_of_a_stiffness():
    rigid = {"contact.model": "newton_impact", "stop.restitution": 0.0}
    recording = simulate(knee(**rigid), 2.0)
    held = recording.impacts[recording.at_stops & (recording.impacts["peak_force"] > 0.0)]
    assert len(held)
    known = Recording("Knee", recording.time, recording.motion, held, recording.walls, recording.wall_names)
    known = replace(known, parameters=recording.parameters, stops=recording.stops)
    assert "stops e = 0" in conditions(known).split("  ·  ")


@pytest.mark.parametrize(
    ("lost", "told"),
    [(0.5, " 50 % "), (0.0123, " 1 % "), (0.002, " 0.2 % "), (3.21e-5, " 0.0032 % "), (1e-14, None)],
)
def test_a_small_share_is_not_told_as_zero(lost, told):
    recording = swing([hit(1.0, 1, "y_max", 1.0)], {"y_max": 1.0})
    total = np.linspace(1.0, 1.0 - lost, 50)
    recording.columns.update({"energy.total": total, "energy.dissipated": 1.0 - total})
    said = message(recording)
    assert (told in said) if told else said == "Swing: 1 impact in 2 s"
