"""How the conversion treats each field of MuJoCo's compiled model and options.

A field is used, or is reported if its value is not the default, or is known to have no effect here. A field
of a newer MuJoCo that is none of these is reported if its value is not 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.differences import Difference, SceneAspect, joint_difference

USED_FIELDS = """
    body_gravcomp body_inertia body_ipos body_iquat body_jntadr body_jntnum body_mass body_mocapid
    body_parentid body_pos body_quat body_weldid
    jnt_actfrclimited jnt_actfrcrange jnt_axis jnt_dofadr jnt_limited jnt_pos jnt_qposadr jnt_range
    jnt_stiffness jnt_type dof_armature dof_damping dof_frictionloss
    qpos0 qpos_spring key_act key_ctrl key_mpos key_mquat key_qpos key_qvel
    geom_bodyid geom_conaffinity geom_condim geom_contype geom_dataid geom_friction geom_pos geom_priority
    geom_quat geom_size geom_type mesh_vert mesh_vertadr mesh_vertnum
    site_bodyid site_pos pair_dim pair_friction pair_geom1 pair_geom2 exclude_signature
    actuator_actadr actuator_armature actuator_biasprm actuator_biastype actuator_ctrladr
    actuator_ctrllimited actuator_ctrlrange actuator_damping actuator_delay actuator_dampingpoly
    actuator_dyntype actuator_forcelimited actuator_forcerange actuator_gainprm actuator_gaintype
    actuator_gear actuator_group actuator_outadr actuator_plugin actuator_trnid actuator_trntype
    eq_active0 eq_obj1id eq_obj2id eq_objtype eq_type wrap_objid wrap_type tendon_adr tendon_num
    tendon_armature tendon_damping tendon_frictionloss tendon_limited tendon_stiffness
    tendon_stiffnesspoly tendon_dampingpoly names name_actuatoradr opt
    opt.gravity opt.disableflags opt.enableflags opt.disableactuator opt.o_friction
"""
"""The fields that the conversion reads: their values are used for the scene, or reported by the code that
reads them."""

IGNORED_FIELDS = {
    "counts, addresses and names": """
        n* name_* paths *adr *rownnz *rowadr *colind signature body_dofnum body_geomnum body_rootid
        body_treeid body_sameframe body_simple tree_body* tree_dof* dof_bodyid dof_jntid dof_parentid
        dof_treeid dof_simplenum jnt_bodyid jnt_actuatorid actuator_actnum actuator_ctrlnum
        actuator_outnum actuator_historyadr tendon_actuatorid tendon_tree* geom_sameframe site_sameframe
        pair_signature efm* D_diag mapD2M mapM2D mapM2M
    """,
    "follow from other fields": """
        body_subtreemass body_invweight0 body_contype body_conaffinity body_margin dof_M0 dof_invweight0
        dof_length actuator_acc0 actuator_length0 actuator_lengthrange tendon_length0 tendon_invweight0
        geom_aabb geom_rbound flg_*
    """,
    "are only seen": """
        cam_* light_* mat_* tex_* skin_* vis stat geom_rgba geom_matid geom_group geom_castshadow site_rgba
        site_matid site_group site_size site_type site_quat site_dataid jnt_group tendon_rgba tendon_matid
        tendon_group tendon_width
    """,
    "are measured, or carried for users": """
        sensor_* numeric_* text_* tuple_* *_user actuator_ctrlspec key_time plugin plugin_attr
        plugin_statenum opt.magnetic
    """,
    "belong to the search for contacts": """
        *bvh* oct_* mesh_* hfield_* opt.ccd_* opt.sdf_*
    """,
    "belong to elements that are reported as a whole": """
        flex* eq_data wrap_prm ten_J* tendon_type tendon_actfrclimited tendon_actfrcrange tendon_range
        tendon_margin tendon_lengthspring tendon_springyield actuator_cranklength actuator_dynprm
        actuator_actlimited actuator_actrange actuator_history opt.wind
    """,
    "hold for steps of time, of which a scene has its own": """
        actuator_actearly tree_sleep_policy opt.timestep opt.integrator opt.sleep_tolerance opt.jacobian
    """,
    "say how soft a constraint is, which is reported with it": """
        *_solref* *_solimp* geom_solmix opt.impratio opt.tolerance opt.ls_* opt.noslip_* opt.iterations
        opt.solver opt.cone opt.o_margin
    """,
}
"""Reason why some fields have no effect here → the names of these fields, in which ``*`` stands for any
text."""
DISABLED = {
    "CONSTRAINT": "no contacts, limits, dry friction or equalities",
    "EQUALITY": "no equalities",
    "FRICTIONLOSS": "no dry friction",
    "LIMIT": "no limits of joints",
    "CONTACT": "no contacts",
    "SPRING": "no springs",
    "DAMPER": "no dampers",
    "GRAVITY": "no gravity",
    "CLAMPCTRL": "no limits of controls",
    "ACTUATION": "no actuators",
}
"""Flag by which a file disables a feature → words for the note, which says that the scene lacks it, too."""
IGNORED_FLAGS = """
    WARMSTART FILTERPARENT REFSAFE SENSOR MIDPHASE EULERDAMP AUTORESET NATIVECCD ISLAND MULTICCD
    OVERRIDE ENERGY FWDINV INVDISCRETE SLEEP DIAGEXACT IPC SPECULATIVE
"""
"""Flags that need no note: they concern the search for contacts, soft contacts, time steps or other features
that scenes do not have. OVERRIDE also replaces the friction of all contacts; mjcf_contacts.py does this."""


class FieldRemark(NamedTuple):
    """A field that is reported for each element whose value of the field is not the default.

    Attributes:
        field: the name of the field.
        kind: the kind of element that has the field.
        default: the default value.
        effect: what a value other than the default changes.
        text: the rest of the sentence on the element, after its kind and name.
        differs: True if the scene has the element in another form, False if the scene does not have it.
    """

    field: str
    kind: str
    default: float
    effect: SceneAspect
    text: str
    differs: bool = False


FIELD_REMARKS = (
    FieldRemark(
        "jnt_stiffnesspoly",
        "joint",
        0,
        SceneAspect.MOTION,
        "its spring is not linear; the scene has its linear part",
    ),
    FieldRemark(
        "jnt_springyield",
        "joint",
        0,
        SceneAspect.LATER_MOTION,
        "its spring yields (springyield), in the scene it does not",
    ),
    FieldRemark(
        "jnt_margin",
        "joint",
        0,
        SceneAspect.CONTACT,
        "its limits act at a margin before the limits; in the scene they act at the limits",
        True,
    ),
    FieldRemark(
        "jnt_actgravcomp", "joint", 0, SceneAspect.MOTION, "gravcomp is part of its drives (actuatorgravcomp)"
    ),
    FieldRemark(
        "dof_dampingpoly",
        "dof",
        0,
        SceneAspect.MOTION,
        "its damping is not linear; the scene has its linear part",
    ),
    FieldRemark("body_plugin", "body", -1, SceneAspect.MOTION, "has a plugin, which is not in the scene"),
    FieldRemark("geom_plugin", "geom", -1, SceneAspect.CONTACT, "has a plugin, which is not in the scene"),
    FieldRemark(
        "geom_margin",
        "geom",
        0,
        SceneAspect.CONTACT,
        "touches at a margin before its surface; in the scene it touches at the surface",
        True,
    ),
    FieldRemark("geom_gap", "geom", 0, SceneAspect.CONTACT, "has a gap, in the scene none", True),
    FieldRemark(
        "geom_surfacevel",
        "geom",
        0,
        SceneAspect.CONTACT,
        "its surface moves (surfacevel), in the scene it does not",
    ),
    FieldRemark(
        "geom_adhesion", "geom", 0, SceneAspect.CONTACT, "sticks (adhesion), in the scene it does not"
    ),
    FieldRemark(
        "geom_fluid",
        "geom",
        0,
        SceneAspect.NONE,
        "has a shape in a fluid (fluidshape), and the scene has no fluid",
    ),
    FieldRemark(
        "pair_margin",
        "pair",
        0,
        SceneAspect.CONTACT,
        "touches at a margin before its surface; in the scene it touches at the surface",
        True,
    ),
    FieldRemark("pair_gap", "pair", 0, SceneAspect.CONTACT, "has a gap, in the scene none", True),
    FieldRemark(
        "pair_adhesion", "pair", 0, SceneAspect.CONTACT, "sticks (adhesion), in the scene it does not"
    ),
    FieldRemark(
        "key_plastic", "keyframe", 0, SceneAspect.MOTION, "has a plastic state, and the scene has none"
    ),
    FieldRemark(
        "opt.density", "option", 0, SceneAspect.MOTION, "the robot moves in a fluid, in the scene in none"
    ),
    FieldRemark(
        "opt.viscosity", "option", 0, SceneAspect.MOTION, "the robot moves in a fluid, in the scene in none"
    ),
)


def unsupported_fields(model: Any) -> Iterator[Difference]:
    """Yield a difference for each element that FIELD_REMARKS reports, and unknown fields that are not 0."""
    values = dict(fields_of_model(model))
    counts = {kind: count(model) for kind, count in COUNTS.items()}
    for row in FIELD_REMARKS:
        if not counts[row.kind]:
            continue
        entries = np.asarray(values[row.field]).reshape(counts[row.kind], -1)
        for i in np.flatnonzero(np.any(entries != row.default, axis=1)):
            yield _difference_of_field(model, row, int(i))
    for field, value in values.items():
        if not treatments(field) and np.any(value):
            text = (
                "is not zero, and not known to this version: it may have an effect, and is not in the scene"
            )
            yield Difference(kind="MuJoCo's field", name=field, text=text, effect=SceneAspect.MOTION)


COUNTS: dict[str, Callable[[Any], int]] = {
    "joint": lambda model: int(model.njnt),
    "dof": lambda model: int(model.nv),
    "body": lambda model: int(model.nbody),
    "geom": lambda model: int(model.ngeom),
    "pair": lambda model: int(model.npair),
    "keyframe": lambda model: int(model.nkey),
    "option": lambda _: 1,
}


def _difference_of_field(model: Any, row: FieldRemark, i: int) -> Difference:
    """Return the difference for the element with index ``i`` of the kind ``row.kind``.

    For a joint, the difference is not reported if the joint is held. For a body or a shape that can move in
    the file, it is not reported if the body is in no link of the scene. Any other difference is reported.
    """
    common_values: dict[str, Any] = {"text": row.text, "effect": row.effect, "differs": row.differs}
    if row.kind == "option":
        return Difference(kind="option", name=row.field[4:], **common_values)
    if row.kind in ("joint", "dof"):
        j = i if row.kind == "joint" else int(model.dof_jntid[i])
        return joint_difference(model.joint(j).name or f"{j}", **common_values)
    element = {"body": model.body, "geom": model.geom, "pair": model.pair, "keyframe": model.key}[row.kind](i)
    bodies = frozenset[int]()
    if row.kind in ("body", "geom"):
        b = i if row.kind == "body" else int(model.geom_bodyid[i])
        bodies = frozenset([b - 1, -1]) if model.body_weldid[b] else bodies
    return Difference(kind=row.kind, name=element.name or f"{i}", bodies=bodies, **common_values)


def treatments(field: str) -> list[str]:
    """Return how a field is treated, as a list: "used" or "remarked", else the reasons why it has no effect.

    The reasons are the keys of IGNORED_FIELDS with a pattern that matches the field. The list is empty for an
    unknown field. ``field`` is the name of a field of the model, or ``opt.<name>`` for an option.
    """
    field_uses = ["used"] * (field in USED_FIELDS.split()) + ["remarked"] * any(
        row.field == field for row in FIELD_REMARKS
    )
    patterns = (
        reason
        for reason, names in IGNORED_FIELDS.items()
        if any(fnmatchcase(field, pattern) for pattern in names.split())
    )
    return field_uses or list(patterns)


def fields_of_model(model: Any) -> Iterator[tuple[str, Any]]:
    """Yield name and value of each field of a model, and of its options, which have names ``opt.<name>``."""
    for prefix, part in (("", model), ("opt.", model.opt)):
        for name in dir(part):
            if not name.startswith("_") and not callable(value := getattr(part, name)):
                yield f"{prefix}{name}", value


def flag_notes(mujoco: Any, model: Any) -> Iterator[str]:
    """Yield one note on all features of DISABLED that the file disables; nothing if there are none."""
    flags = model.opt.disableflags
    disabled = [
        text for name, text in DISABLED.items() if flags & getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}")
    ]
    if disabled:
        yield f"flags: {', '.join(disabled)}, in the file and in the scene"
