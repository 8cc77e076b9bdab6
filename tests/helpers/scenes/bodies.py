"""Small scenes of a body with points beside its line, and of a cart on a slider."""

from chain_impact.scene.scene import Scene, scene_from_dict

SHIN = {"length": 0.25, "mass": 0.5, "shape": "box", "height": 0.04}


def body() -> Scene:
    """Return two links that fall on a rough floor: a foot with its mass beside its line, and a box."""
    heel, toe = {"x": 0.05, "y": -0.1, "name": "heel"}, {"x": 0.45, "y": -0.08, "radius": 0.01, "name": "toe"}
    foot = {"length": 0.5, "mass": 1.0, "center_of_mass_offset": 0.04, "points": [heel, toe]}
    scene = {
        "name": "Body",
        "chain": {"links": [foot, {**SHIN, "joint_damping": 0.05}]},
        "box": {"y_min": 0.0},
        "contact": {"stiffness": 1e6, "restitution": 0.5, "friction": 0.3, "points": [2]},
        "initial": {"position": [0.0, 0.5], "angles": [0.5, 1.25], "angular_velocities": [-1.0, 0.0]},
        "outputs": {"loads": True},
    }
    return scene_from_dict(scene, "body")


def cart() -> Scene:
    """Return a cart with a pole on a sloping line, which has stops, a spring, dry friction and a motor."""
    slider = {"angle": 0.1, "mass": 2.0, "damping": 0.4, "stiffness": 5.0, "rest_position": 0.05}
    slider |= {"friction": 0.2, "min": -0.2, "max": 0.2, "force_limit": 10.0}
    scene = {
        "name": "Cart",
        "chain": {
            "base": "slider",
            "slider": slider,
            "links": [{"length": 0.5, "mass": 0.5, "center_of_mass_offset": 0.02}],
        },
        "contact": {"stiffness": 1e6, "restitution": 0.6, "points": []},
        "inputs": {"slider_force": True},
        "initial": {"angles": [1.2], "slider_velocity": 1.0},
        "outputs": {"loads": True},
    }
    return scene_from_dict(scene, "cart")
