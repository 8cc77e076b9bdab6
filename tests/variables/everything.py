"""Two scenes that together have every kind of variable."""

from chain_impact import load_scene

EVERYTHING = load_scene("four_link_box").with_values(
    {
        "link[2].joint_min": -2.0,
        "link[2].joint_friction": 0.1,
        "contact.friction": 0.1,
        "inputs.wall_motion": True,
        "outputs.loads": True,
        "outputs.impacts": 1,
        "walls": [{"name": "slope", "point": [0.0, -9.0], "angle": 0.0}],
        "signals": {
            "sway": {"input": "wall.slope.displacement", "form": "sine", "amplitude": 0.1, "frequency": 2.0},
            "runs": {"input": "wall.slope.belt_speed", "form": "steps", "times": [0.0], "values": [1.0]},
        },
        ("chain", "links", 1, "points"): [{"x": 0.2, "y": 0.01, "name": "knee"}],
    }
)
CART = EVERYTHING.with_values(
    {"chain.base": "slider", "chain.slider": {"friction": 1.0}, "initial.velocity": [0, 0]}
)
