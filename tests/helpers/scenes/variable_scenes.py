"""Scenes with all kinds of variables, and the variables of a scene by name."""

from chain_impact import load_scene
from chain_impact.kernel.record.constants import WALLS
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import Scene, with_values
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.variable import Variable
from tests.helpers.scenes.friction import pendulum

DRIVEN = {("inputs", "joint_torques"): True, ("inputs", "tip_force"): True}
STOPS = {"link[2].joint_min": -2.0, "link[2].joint_max": 2.0, "link[4].joint_max": 1.5, "stop.stiffness": 1e4}
MATERIALS = {"wall.y_min.stiffness": 1e7, "wall.y_min.restitution": 0.25, "wall.x_max.restitution": 0.5}
FRICTION = {"contact.friction": 0.3, "contact.static_friction": 0.4, "wall.x_max.static_friction": 0.5}
FRICTION |= {"link[3].joint_friction": 0.2}
NO_POINTS = {("contact", "points"): []}
SHAKEN = {"signals": {"shake": {"input": "base.x", "form": "sine", "amplitude": 0.01, "frequency": 5.0}}}


def scenes() -> dict[str, Scene]:
    models = {name: load_scene(name) for name in model_names()}
    box = models["four_link_box"]
    return models | {
        "driven": with_values(box, DRIVEN),
        "without walls": with_values(box, {("box", wall): None for wall in WALLS}),
        "two points": with_values(box, {("contact", "points"): [0, 3]}),
        "walls without points": with_values(models["ramp"], {("contact", "points"): []}),
        "stops": with_values(box, STOPS),
        "stops only": with_values(models["simple_pendulum"], {"link[1].joint_max": 7.0, **NO_POINTS}),
        "materials": with_values(box, MATERIALS),
        "friction": with_values(box, FRICTION | STOPS),
        "loads": with_values(box, FRICTION | STOPS | {"outputs.loads": True}),
        "friction in joints": pendulum(),
        "signals": with_values(models["shaken_pendulum"], SHAKEN),
        "slanted": with_values(box, {("walls",): [{"name": "slope", "point": [0.0, 0.0], "angle": -0.75}]}),
    }


SCENES = scenes()


def variables(scene: Scene) -> dict[str, Variable]:
    return {variable.name: variable for variable in PreparedScene(scene).variables}


def names(scene: Scene, causality: str) -> list[str]:
    return [variable.name for variable in PreparedScene(scene).variables if variable.causality == causality]
