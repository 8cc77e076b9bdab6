"""The parameters in the table of variables: their kinds, whose attributes kind.py explains.

The dataclasses of the scene (in scene/keys) have the meaning, the unit and the range of each
parameter. The kinds add the path of the value in the record, and which scenes have the parameter. The value
references follow the order of the kinds.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from chain_impact.kernel.record.constants import WALLS
from chain_impact.scene.contents import SceneContents
from chain_impact.scene.facts import TRUE_FACT
from chain_impact.scene.keys.chain_tables import Link, Site, Slider
from chain_impact.scene.keys.signal_tables import NUMBERS, Signal
from chain_impact.scene.keys.tables import Box, Contact, Initial, Material, Simulation, Solver, Stops, Wall
from chain_impact.scene.texts.names import ENTRY_AT, LINK_AT, OWNER_AT
from chain_impact.variables.key_kinds import (
    AXIS,
    INDEX,
    KEY,
    key_metadata,
    parameter_kind,
    table_kinds,
    vector_kinds,
)
from chain_impact.variables.kind import (
    GIVEN_CHANNEL,
    LINK,
    SIGNAL,
    SITE,
    SLIDER,
    SLOPED_WALL,
    WALL,
    block,
)

LAWS, METHODS = "laws", "methods"
"""The names of the lists of choices (``choices_of``): contact laws, and methods of the solver."""
DRY_HINT = "it is a parameter if the scene has this dry friction: give it a value in the scene file first"
GIVEN_HINT = "it is a parameter if the scene file gives it: give it a value there first"
_ONLY_IF_GIVEN = {"only_if_in_file": True, "hint": GIVEN_HINT}


def _drive(field: str, part: str = "drive", **attributes: Any) -> dict[str, Any]:
    """Return the attributes of a value that the record has for each drive, of a joint or of the slider.

    ``part`` and ``field`` are those of the record, ``attributes`` the others.
    """
    return {"record_path": (part, field, OWNER_AT), **attributes}


_DAMPING = _drive("drive_damping", "given", tunable="has_target")
_STIFFNESS = _drive("drive_stiffness", "given", tunable="has_target")
_FRICTION = _drive("friction", when=("may_have_friction",), hint=DRY_HINT)
_LIMIT = _drive("limit", number_for_none=math.inf, hint=GIVEN_HINT)
_MIN, _MAX = _drive("min", number_for_none=-math.inf), _drive("max", number_for_none=math.inf)
_ANGLE_TARGET, _POSITION_TARGET = (
    _drive(
        "target",
        "given",
        when=("target_is_parameter",),
        hint=f"with inputs.joint_targets it is the start value of the target {noun}: vary or fit the value "
        "of a constant signal of the target instead",
    )
    for noun in ("angle", "position")
)
_COEFFICIENT: dict[str, Any] = {
    "tunable": TRUE_FACT,
    "when": ("has_contact_friction",),
    "value_if_not_in_file": 0.0,
    "hint": DRY_HINT,
}
"""The attributes that both coefficients of friction of [contact], sliding and static, have in common."""

PARAMETERS = (
    block(
        "one",
        *vector_kinds(
            SceneContents,
            scene_path=("gravity",),
            record_path=("chain", "gravity", INDEX),
            text="{axis} of the {}",
        ),
    ),
    block(
        "link",
        *table_kinds(
            Link,
            scene_path=("chain", "links", OWNER_AT, KEY),
            record_path=("chain", KEY, OWNER_AT),
            names=[key for key in key_metadata(Link) if key not in ("points", "shape")],
            height={"number_for_none": 0.0, "hint": GIVEN_HINT},
            center_of_mass_offset=_ONLY_IF_GIVEN,
            center_of_mass={"given_path": ("chain", "given_center_of_mass", OWNER_AT)},
            inertia={"given_path": ("chain", "given_inertia", OWNER_AT)},
            joint_damping=_DAMPING,
            joint_stiffness=_STIFFNESS,
            joint_rest_angle=_ANGLE_TARGET,
            joint_friction=_FRICTION,
            joint_armature=_ONLY_IF_GIVEN,
            joint_torque_limit=_LIMIT,
            joint_min=_MIN,
            joint_max=_MAX,
        ),
        heading=LINK,
    ),
    block(
        "site",
        *table_kinds(
            Site,
            scene_path=("chain", "links", LINK_AT, "points", ENTRY_AT, KEY),
            record_path=("site", KEY, OWNER_AT),
            names=("x", "y", "radius"),
            radius={"given_path": ("site", "given_radius", OWNER_AT)},
        ),
        heading=SITE,
        when=("in_file",),
    ),
    block(
        "slider",
        *table_kinds(
            Slider,
            scene_path=("chain", "slider", KEY),
            record_path=("drive", KEY, OWNER_AT),
            angle={"record_path": ("slider", "angle")},
            mass={"record_path": ("slider", "mass")},
            damping=_DAMPING,
            stiffness=_STIFFNESS,
            rest_position=_POSITION_TARGET,
            friction=_FRICTION,
            min=_MIN,
            max=_MAX,
            force_limit=_LIMIT,
        ),
        parameter_kind(
            key_metadata(Initial)["slider_velocity"],
            scene_path=("initial", "slider_velocity"),
            record_path=("initial", "slider_velocity"),
            text="initial {}",
        ),
        heading=SLIDER,
    ),
    block(
        "one",
        *(
            kind
            for w, wall in enumerate(WALLS)
            for kind in table_kinds(
                Box,
                scene_path=("box", KEY),
                record_path=("chain", "box_wall", w),
                names=(wall,),
                text="position of the {}",
            )
        ),
    ),
    block(
        "sloped wall",
        *vector_kinds(
            Wall,
            scene_path=("walls", OWNER_AT, "point"),
            record_path=("walls", AXIS, OWNER_AT),
            text="{axis} of {}",
        ),
        *table_kinds(
            Wall,
            scene_path=("walls", OWNER_AT, KEY),
            record_path=("walls", KEY, OWNER_AT),
            names=("angle",),
        ),
        heading=SLOPED_WALL,
        when=("has_contacts",),
    ),
    block(
        "one",
        *table_kinds(
            Contact,
            scene_path=("contact", KEY),
            record_path=("given", "law"),
            names=("model",),
            model={"when": ("has_law",), "tunable": TRUE_FACT, "choices": LAWS, "smooth": False},
        ),
    ),
    block(
        "one",
        *table_kinds(
            Contact,
            scene_path=("contact", KEY),
            record_path=("contact_settings", KEY),
            names=("stiffness", "exponent", "restitution", "radius", "minimum_impact_speed"),
            stiffness={"record_path": ("given", "stiffness"), "tunable": TRUE_FACT},
            restitution={"record_path": ("given", "restitution"), "tunable": TRUE_FACT},
            minimum_impact_speed={"smooth": False},
        ),
        *table_kinds(
            Contact,
            scene_path=("contact", KEY),
            record_path=("given", KEY),
            names=("friction", "static_friction"),
            friction=_COEFFICIENT,
            static_friction=_COEFFICIENT,
        ),
        when=("has_contacts",),
    ),
    block(
        "material",
        *table_kinds(
            Material,
            scene_path=("contact", "wall", "{name}", KEY),
            record_path=("walls", KEY, OWNER_AT),
            # −1 in the record means that the value of [contact] applies to this wall; a static friction of −1
            # beside a sliding friction of the wall means that both are equal
            restitution={"number_for_none": -1.0},
            friction={"number_for_none": -1.0, "hint": DRY_HINT},
            static_friction={"number_for_none": -1.0, "hint": DRY_HINT},
        ),
        heading=WALL,
        when=("has_contacts",),
        tunable=TRUE_FACT,
    ),
    block(
        "one",
        *table_kinds(
            Stops,
            scene_path=("stops", KEY),
            record_path=("stops", KEY),
            names=("stiffness", "exponent", "restitution", "minimum_impact_speed"),
            stiffness={"record_path": ("given", "stop_stiffness"), "tunable": TRUE_FACT},
            exponent={"given_path": ("stops", "given_exponent")},
            restitution={"given_path": ("given", "stop_restitution"), "tunable": TRUE_FACT},
            minimum_impact_speed={"smooth": False},
        ),
        when=("stop_count",),
    ),
    block(
        "one",
        # if inputs move the base, a new initial position is also written to the inputs for the base's
        # position
        *(
            replace(kind, given_path=(GIVEN_CHANNEL, "position", j), stores_given_if="inputs.base_motion")
            for j, kind in enumerate(
                vector_kinds(
                    Initial,
                    scene_path=("initial", "position"),
                    record_path=("initial", "position", INDEX),
                    text="initial {axis} of the {}",
                )
            )
        ),
        # only for a free base: inputs may move a pinned base, and a slider has initial.slider_velocity
        *vector_kinds(
            Initial,
            scene_path=("initial", "velocity"),
            record_path=("initial", "velocity", INDEX),
            text="initial {axis} of the {}",
            when=("free",),
        ),
    ),
    *(
        block(
            "link",
            parameter_kind(
                key_metadata(Initial)[key],
                scene_path=("initial", key, OWNER_AT),
                record_path=("initial", name, OWNER_AT),
                text="initial " + key_metadata(Initial)[key]["description"].replace("each link", "link {n}"),
            ),
        )
        for key, name in (("angles", "angle"), ("angular_velocities", "angular_velocity"))
    ),
    block(
        "signal",
        *table_kinds(
            Signal,
            scene_path=("signals", "{name}", KEY),
            record_path=("signal", KEY, OWNER_AT),
            names=NUMBERS,
        ),
        heading=SIGNAL,
    ),
    block(
        "step",
        parameter_kind(
            key_metadata(Signal)["times"],
            scene_path=("signals", "{name}", "times", ENTRY_AT),
            record_path=("knot", "given_time", OWNER_AT),
        ),
        parameter_kind(
            key_metadata(Signal)["values"],
            scene_path=("signals", "{name}", "values", ENTRY_AT),
            record_path=("knot", "given_value", OWNER_AT),
        ),
        heading=SIGNAL,
    ),
    block(
        "one",
        *table_kinds(
            Solver, scene_path=("solver", KEY), record_path=("solver", KEY), method={"choices": METHODS}
        ),
        smooth=False,
    ),
)
"""The kinds of all parameters that scenes can have, in blocks."""
DERIVED_DURING_RUN = tuple(
    kind.record_path[:2] for _, kinds in PARAMETERS for kind in kinds if kind.given_path and kind.tunable
)
"""The fields of the record with values in use that follow from other values during a run, as long as the user
does not give them: part of the record and field."""
SIMULATION_KINDS = table_kinds(Simulation, scene_path=("simulation", KEY), record_path=())
"""The kinds for the keys of [simulation], which are no parameters: the record does not have their values."""
