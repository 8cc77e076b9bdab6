"""Random scenes of bodies with offset centres of mass and points: on sliders, on moving bases, and thrown."""

from __future__ import annotations

from typing import Any

from tests.helpers.campaigns.random_parts import Draw

Given = tuple[dict[str, Any], dict[str, Any]]  # a scene as a table, and inputs


def carts(draw: Draw) -> Given:
    """Return a chain on a slider that a sine pushes, with stops, a limit of force, and some dry friction."""
    slider = {
        "angle": draw.real(-0.5, 0.5),
        "mass": draw.power(0.3, 4.0),
        "damping": draw.power(0.1, 3.0),
        "stiffness": draw.power(3.0, 100.0),
        "rest_position": draw.real(-0.1, 0.1),
        "friction": draw.real(0.1, 2.0) * draw.chance(0.4),
        "force_limit": draw.power(1.0, 20.0),
        "min": draw.real(-0.3, -0.05),
        "max": draw.real(0.05, 0.3),
    }
    links = [_body(draw) for _ in range(draw.whole(1, 2))]
    push = {
        "input": "slider.force",
        "form": "sine",
        "mean": draw.real(-2.0, 2.0),
        "amplitude": draw.power(1.0, 20.0),
        "frequency": draw.real(0.5, 4.0),
    }
    return {
        "name": "Cart",
        "chain": {"base": "slider", "slider": slider, "links": links},
        "box": {"y_min": -draw.real(0.2, 0.6)},
        "contact": {"restitution": draw.real(0.3, 0.8), "stiffness": draw.power(1e4, 1e6), "radius": 0.01},
        "inputs": {"slider_force": True},
        "signals": {"push": push},
        "initial": {"angles": [draw.real(-0.1, 0.2) for _ in links], "slider_velocity": draw.real(-1.0, 1.0)},
        "outputs": {"loads": True},
        "solver": {"tolerance": 1e-10},
        "simulation": {"stop_time": 0.8, "step_size": 2e-3},
    }, {}


def moved_bases(draw: Draw) -> Given:
    """Return a pinned chain whose base moves with an acceleration that jumps."""
    ramp = {"form": "ramp", "start": draw.real(0.05, 0.2), "duration": draw.real(0.1, 0.3)}
    push = draw.one(
        (
            {"input": "base.y", **ramp, "final": draw.real(-0.05, 0.05), "shape": "trapezoid"},
            {"input": "base.vx", **ramp, "final": draw.real(-0.5, 0.5), "shape": "linear"},
            {
                "input": "base.ay",
                "form": "steps",
                "times": [0.0, draw.real(0.05, 0.2), draw.real(0.25, 0.4)],
                "values": [0.0, draw.real(-5.0, 5.0), 0.0],
            },
        )
    )
    links = [_body(draw) for _ in range(draw.whole(1, 2))]
    return {
        "name": "Moved",
        "chain": {"base": "pinned", "links": links},
        "box": {"y_min": -draw.real(0.3, 0.6)},
        "contact": {"restitution": draw.real(0.3, 0.8), "stiffness": draw.power(1e4, 1e6), "radius": 0.01},
        "inputs": {"base_motion": True},
        "signals": {"push": push},
        "initial": {"angles": [draw.real(-0.3, 0.2) for _ in links]},
        "outputs": {"loads": True},
        "solver": {"tolerance": 1e-10},
        "simulation": {"stop_time": 0.6, "step_size": 2e-3},
    }, {}


def bodies(draw: Draw) -> Given:
    """Return one or two links with offset centres of mass and more points, thrown on a floor."""
    links = [_body(draw) for _ in range(draw.whole(1, 2))]
    return {
        "name": "Body",
        "chain": {"links": links},
        "box": {"y_min": 0.0},
        "contact": {
            "restitution": draw.real(0.3, 0.8),
            "stiffness": draw.power(1e4, 1e6),
            "radius": 0.01,
            "friction": draw.real(0.1, 0.6) * draw.chance(0.4),
        },
        "initial": {
            "position": [0.0, draw.real(0.5, 0.9)],
            "velocity": [draw.real(-2.0, 2.0), 0.0],
            "angles": [draw.real(-0.6, 0.6) for _ in links],
            "angular_velocities": [draw.real(-3.0, 3.0) for _ in links],
        },
        "outputs": {"loads": True},
        "solver": {"tolerance": 1e-10},
        "simulation": {"stop_time": 0.8, "step_size": 2e-3},
    }, {}


def _body(draw: Draw) -> dict[str, Any]:
    """Return a link with an offset centre of mass and two points beside its line."""
    length = draw.real(0.2, 0.5)
    return {
        "length": length,
        "mass": draw.real(0.3, 1.5),
        "center_of_mass_offset": draw.real(-0.05, 0.05),
        "joint_damping": draw.real(0.0, 0.05),
        "points": [{"x": draw.real(0.0, length), "y": draw.real(-0.1, 0.1)} for _ in range(2)],
    }
