"""Couplings between joints and bodies of an MJCF model, which scenes do not have.

These couplings are equalities, tendons and flexes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from chain_impact.conversion.differences import Difference, SceneAspect

FORCES: dict[str, set[str]] = {
    "tendon_stiffness": {"mjDSBL_SPRING"},
    "tendon_stiffnesspoly": {"mjDSBL_SPRING"},
    "tendon_damping": {"mjDSBL_DAMPER"},
    "tendon_dampingpoly": {"mjDSBL_DAMPER"},
    "tendon_frictionloss": {"mjDSBL_FRICTIONLOSS", "mjDSBL_CONSTRAINT"},
    "tendon_limited": {"mjDSBL_LIMIT", "mjDSBL_CONSTRAINT"},
    "tendon_armature": set(),
}
"""Field of the model that gives tendons an effect → flags each of which disables this effect."""


def joints_between(model: Any, bodies: Sequence[int]) -> frozenset[str]:
    """Return the names of the joints of a model that move some of ``bodies``, by index, and not all alike."""
    paths: list[set[int]] = []
    for body in bodies:
        path, b = set[int](), int(body)
        while b > 0:
            path |= set(range(model.body_jntadr[b], model.body_jntadr[b] + model.body_jntnum[b]))
            b = int(model.body_parentid[b])
        paths.append(path)
    joints = set[int]().union(*paths) - paths[0].intersection(*paths) if paths else set[int]()
    return frozenset(model.joint(j).name or f"{j}" for j in joints)


def coupling_differences(mujoco: Any, model: Any) -> Iterator[Difference]:
    """Yield a difference for each active equality, each tendon with an effect, and each flex of a model."""
    flags, bits = model.opt.disableflags, mujoco.mjtDisableBit
    disabled_names = {
        name for name in dir(bits) if name.startswith("mjDSBL_") and flags & int(getattr(bits, name))
    }
    if not {"mjDSBL_EQUALITY", "mjDSBL_CONSTRAINT"} & disabled_names:
        for e in np.flatnonzero(model.eq_active0):
            yield _equality(mujoco, model, int(e))
    for t in range(model.ntendon):
        yield from _tendon(mujoco, model, t, disabled_names)
    for f in range(model.nflex):
        yield Difference(kind="flex", name=f"{f}", text="is not in the scene", effect=SceneAspect.MOTION)


def _equality(mujoco: Any, model: Any, e: int) -> Difference:
    """Return the difference for the equality constraint with index ``e``, which the scene does not have."""
    kinds, ids = mujoco.mjtObj, (int(model.eq_obj1id[e]), int(model.eq_obj2id[e]))
    kind = mujoco.mjtEq(model.eq_type[e]).name.removeprefix("mjEQ_").lower()
    joints, bodies = frozenset[str](), frozenset[int]()
    if kind == "joint":
        joints = frozenset(model.joint(j).name or f"{j}" for j in ids if j >= 0)
    elif kind == "tendon":
        joints = frozenset().union(*(tendon_joints(mujoco, model, t) for t in ids if t >= 0))
    elif (object_kind := kinds(model.eq_objtype[e])) in (kinds.mjOBJ_BODY, kinds.mjOBJ_SITE):
        body_ids = [int(model.site_bodyid[i]) if object_kind == kinds.mjOBJ_SITE else i for i in ids]
        joints = joints_between(model, body_ids)
        bodies = frozenset() if joints else frozenset(b - 1 for b in body_ids)
    return Difference(
        kind="equality",
        name=model.equality(e).name or f"{e}",
        text=f"{kind}: is not in the scene",
        effect=SceneAspect.MOTION,
        joints=joints,
        bodies=bodies,
    )


def _tendon(mujoco: Any, model: Any, t: int, disabled_names: set[str]) -> Iterator[Difference]:
    """Yield a difference for the tendon with index ``t`` if the tendon has an effect on the motion.

    The tendon has an effect if its length can change, a field in FORCES is not 0 for it, and the file does
    not disable this effect. ``disabled_names`` has the names (mjDSBL_…) of all flags by which the file
    disables features.
    """
    acting = [
        field.removeprefix("tendon_")
        for field, flags in FORCES.items()
        if np.any(getattr(model, field)[t]) and not flags & disabled_names
    ]
    joints = tendon_joints(mujoco, model, t)
    if not (acting and joints):
        return
    yield Difference(
        kind="tendon",
        name=model.tendon(t).name or f"{t}",
        text=f"{', '.join(acting)}: is not in the scene",
        effect=SceneAspect.LATER_MOTION if acting == ["limited"] else SceneAspect.MOTION,
        joints=joints,
    )


def tendon_joints(mujoco: Any, model: Any, t: int) -> frozenset[str]:
    """Return the names of the joints on which the length of the tendon with index ``t`` depends."""
    joints, bodies = set[str](), list[int]()
    kinds = mujoco.mjtWrap
    for w in range(model.tendon_adr[t], model.tendon_adr[t] + model.tendon_num[t]):
        i, kind = int(model.wrap_objid[w]), kinds(model.wrap_type[w])
        if kind == kinds.mjWRAP_JOINT:
            joints.add(model.joint(i).name or f"{i}")
        elif kind == kinds.mjWRAP_SITE:
            bodies.append(int(model.site_bodyid[i]))
        elif kind in (kinds.mjWRAP_SPHERE, kinds.mjWRAP_CYLINDER):
            bodies.append(int(model.geom_bodyid[i]))
    return frozenset(joints) | joints_between(model, bodies)
