"""The kinds of FMU, and the scenes of their tests."""

from pathlib import Path

from chain_impact import Scene, load_scene
from chain_impact.fmu.build import build_fmu
from tests.helpers.scenes.bodies import body, cart
from tests.helpers.scenes.derived_scenes import finger
from tests.helpers.scenes.friction import thrown
from tests.helpers.scenes.friction_derivative_scenes import dry_joints
from tests.helpers.scenes.stops import knee_scene
from tests.helpers.tools.shared import make_once

KINDS = {
    "pythonfmu": {"target": "pythonfmu"},
    "native": {"target": "native"},
    "fmi3": {"target": "native", "fmi": 3},
}
"""The kinds of FMU → options of the build. The first two kinds are for FMI 2.0."""

PARAMETERS = ["contact.stiffness", "contact.restitution", "initial.angle[*]"]
FLAT = {"box.x_max": 9.0, "contact.model": "newton_impact", "initial.velocity": [0.0, 0.0]}
FLAT |= {"initial.angles": [0.0] * 4, "initial.angular_velocities": [0.0] * 4}
SERVO = {
    f"link[{i}].joint_{key}": value for i in (1, 2) for key, value in (("stiffness", 4.0), ("damping", 0.3))
}
SERVO |= {"link[1].joint_armature": 0.1, "link[2].joint_torque_limit": 2.0, "inputs.joint_targets": True}
SCENES = {
    "body": body,
    "cart": cart,
    "led_cart": lambda: cart().with_values({"inputs.joint_targets": True}),
    "derivatives": lambda: load_scene("four_link_box").with_values(
        {"outputs.sensitivities": PARAMETERS, "outputs.contacts": False}
    ),
    "flat_derivatives": lambda: load_scene("four_link_box").with_values(
        FLAT | {"outputs.sensitivities": ["contact.restitution"]}
    ),
    "dry_derivatives": lambda: dry_joints(4).scene.with_values(
        {"outputs.sensitivities": [f"link[{i}].joint_friction" for i in (1, 3)]}
    ),
    "knee": knee_scene,
    "thrown": thrown,
    "finger": finger,
    "servo": lambda: load_scene("pinned_arm").with_values(SERVO | {"outputs.loads": True}),
    "moved_arm": lambda: load_scene("pinned_arm").with_values(
        {"inputs.base_motion": True, "inputs.wall_motion": True, "contact.friction": 0.3}
    ),
    "pushed_leg": lambda: load_scene("kneed_leg").with_values({"inputs.tip_force": True}),
    "pushed_rigid_arm": lambda: load_scene("falling_arm").with_values(
        {"inputs.tip_force": True, "contact.model": "newton_impact", "contact.restitution": 0.0}
    ),
}
"""Scenes of tests, by name; their FMUs are listed with the FMUs of the models."""


def scene_of(name: str) -> Scene:
    """Return the scene of an FMU."""
    return SCENES[name]() if name in SCENES else load_scene(name)


class OnDemand(dict[str, str]):
    """The FMU of each scene, built at the first access: name of the scene → path."""

    def __init__(self, kind: str, folder: Path) -> None:
        self.kind, self.folder = kind, folder
        folder.mkdir(exist_ok=True)

    def __missing__(self, name: str) -> str:
        folder = make_once(
            self.folder / name, lambda folder: build_fmu(scene_of(name), folder, **KINDS[self.kind])
        )
        (fmu,) = folder.glob("*.fmu")
        self[name] = str(fmu)
        return self[name]
