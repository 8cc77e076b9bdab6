"""The contacts that are possible in an MJCF model by MuJoCo's rules, and the friction in these contacts."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from chain_impact.conversion.differences import Difference, SceneAspect
from chain_impact.conversion.robot import LinkShape, Plane, identifier, shape_outline

POINT = re.compile(r"point\[\d+\]")  # matches the names that ``point_name`` gives to shapes
BITS = 16  # MuJoCo stores a pair of bodies that may not touch as one integer: (first << BITS) + second


def point_name(number: int) -> str:
    """Return the name of the shape that stands for point ``number`` of a scene in files of this package."""
    return f"point[{number}]"


class Contacts:
    """The shapes of a MuJoCo model, and which of these shapes can touch each other.

    The method ``differences`` yields the contacts that a scene cannot have, or has in another form.
    """

    def __init__(self, mujoco: Any, model: Any, stand_ins: set[str], is_own: bool) -> None:
        """Divide the shapes of a model into those that can move, and those that are fixed to the world.

        Args:
            mujoco: the package.
            model: the compiled model.
            stand_ins: names of meshes that replace missing files; their corners have no meaning.
            is_own: whether this package wrote the file.
        """
        self.mujoco, self.model, self.is_own = mujoco, model, is_own
        self.stand_ins = {m for m in range(model.nmesh) if model.mesh(m).name in stand_ins}
        flags, bits = model.opt.disableflags, mujoco.mjtDisableBit
        self.has_contacts = not flags & (bits.mjDSBL_CONTACT | bits.mjDSBL_CONSTRAINT)
        override = model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE
        self.friction = float(model.opt.o_friction[0]) if override else None
        self.pairs = {
            frozenset((int(model.pair_geom1[p]), int(model.pair_geom2[p]))): p for p in range(model.npair)
        }
        self.excluded = {int(signature) for signature in model.exclude_signature}
        self.still_geoms = [g for g in range(model.ngeom) if self._is_still(g)]
        self.moving_geoms = [g for g in range(model.ngeom) if not self._is_still(g)]
        self.walls = [g for g in self.still_geoms if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_PLANE]

    def _is_still(self, g: int) -> bool:
        return bool(self.model.body_weldid[self.model.geom_bodyid[g]] == 0)

    def _can_touch(self, geom: int, other_geom: int) -> bool:
        """Return whether two shapes, given by their indices, can touch each other, by rules of MuJoCo.

        The result is False if the file disables contacts, else True if the file lists the shapes as a pair.
        For other shapes it is True if ``contype`` of one shape and ``conaffinity`` of the other have a bit in
        common, and their bodies are neither an excluded pair nor fixed to each other. MuJoCo's rule that a
        body does not touch its parent is left out.
        """
        model = self.model
        if not self.has_contacts:
            return False
        if frozenset((geom, other_geom)) in self.pairs:
            return True
        first_body, second_body = sorted((int(model.geom_bodyid[geom]), int(model.geom_bodyid[other_geom])))
        if (first_body << BITS) + second_body in self.excluded or model.body_weldid[
            first_body
        ] == model.body_weldid[second_body]:
            return False
        types, affinities = model.geom_contype, model.geom_conaffinity
        return bool(types[geom] & affinities[other_geom] or types[other_geom] & affinities[geom])

    def _sliding_friction(self, geom: int, other_geom: int) -> float:
        """Return the coefficient of sliding friction between two shapes, by MuJoCo's rules.

        A listed pair has its own coefficient. Otherwise the coefficient is that of the shape with the higher
        priority or, with equal priorities, the larger of both coefficients. The coefficient of an override
        in the file replaces these. A contact with ``condim`` 1 has no friction: the result is 0.
        """
        model = self.model
        if frozenset((geom, other_geom)) in self.pairs:
            p = self.pairs[frozenset((geom, other_geom))]
            has_friction, friction = model.pair_dim[p] > 1, float(model.pair_friction[p, 0])
        else:
            highest_priority = max(model.geom_priority[geom], model.geom_priority[other_geom])
            ruling = [g for g in (geom, other_geom) if model.geom_priority[g] == highest_priority]
            has_friction = max(model.geom_condim[g] for g in ruling) > 1
            friction = max(float(model.geom_friction[g, 0]) for g in ruling)
        friction = friction if self.friction is None else self.friction
        return friction if has_friction else 0.0

    def planes(self) -> Iterator[Plane]:
        """Yield the planes fixed to the world, each with the bodies that can touch it, and their friction."""
        model, data = self.model, self.mujoco.MjData(self.model)
        self.mujoco.mj_kinematics(model, data)
        for g in self.walls:
            touching_geoms = [
                (int(model.geom_bodyid[other_geom]) - 1, self._sliding_friction(g, other_geom))
                for other_geom in self.moving_geoms
                if self._can_touch(g, other_geom)
            ]
            yield Plane(
                name=model.geom(g).name or f"{g}",
                point=np.array(data.geom_xpos[g]),
                normal=np.array(data.geom_xmat[g].reshape(3, 3)[:, 2]),
                contacts=touching_geoms,
            )

    def shapes(self, b: int) -> list[LinkShape]:
        """Return the shapes of body ``b`` of MuJoCo's model, except planes that are fixed to the world."""
        model = self.model
        first = model.body_geomadr[b]  # −1 without shapes
        geoms = range(first, first + model.body_geomnum[b])
        return [self._shape(g) for g in geoms if g not in self.walls]

    def _shape(self, g: int) -> LinkShape:
        model, kinds = self.model, self.mujoco.mjtGeom
        kind = kinds(model.geom_type[g])
        rotation = np.zeros(9)
        self.mujoco.mju_quat2Mat(rotation, model.geom_quat[g])
        word, radius, disc = kind.name.removeprefix("mjGEOM_").lower(), 0.0, None
        if kind == kinds.mjGEOM_MESH and model.geom_dataid[g] not in self.stand_ins:
            m = model.geom_dataid[g]
            start = model.mesh_vertadr[m]
            corners = np.array(model.mesh_vert[start : start + model.mesh_vertnum[m]], float)
        elif kind == kinds.mjGEOM_MESH:
            corners = np.zeros((0, 3))
        else:  # for a kind that ``shape_outline`` does not know, such as an ellipsoid, it returns a box
            corners, radius, disc = shape_outline(word, model.geom_size[g])
        axes, name = rotation.reshape(3, 3), model.geom(g).name
        other_geoms = self.moving_geoms if self._is_still(g) else range(model.ngeom)
        # if a scene of this package has no walls, its points touch nothing, but must be kept
        is_point = self.is_own and bool(POINT.fullmatch(name))
        is_alone = is_point and not self.walls and self.has_contacts
        return LinkShape(
            kind=word,
            touches=is_alone
            or any(self._can_touch(g, other_geom) for other_geom in other_geoms if other_geom != g),
            name=identifier(name, "geom") if name else "",
            walls=any(self._can_touch(g, wall) for wall in self.walls),
            is_point=is_point,
            corners=corners @ axes.T + model.geom_pos[g],
            radius=radius,
            disc=None if disc is None else axes @ disc,
        )

    def differences(self) -> Iterator[Difference]:
        """Yield a difference for each shape fixed to the world, except planes, that moving bodies can touch.

        Only planes become walls. If a moving body can touch a plane that is fixed to the world, a further
        difference says that such contacts are soft in MuJoCo.
        """
        model = self.model
        has_walls = False
        for g in self.still_geoms:
            bodies = frozenset(
                int(model.geom_bodyid[o]) - 1 for o in self.moving_geoms if self._can_touch(g, o)
            )
            has_walls |= g in self.walls and bool(bodies)
            if bodies and g not in self.walls:
                kind = self.mujoco.mjtGeom(model.geom_type[g]).name.removeprefix("mjGEOM_").lower()
                text = "does not move, and touches moving bodies: only planes become walls of a scene"
                part_numbers = bodies | {-1}
                yield Difference(
                    kind=kind,
                    name=model.geom(g).name or f"{g}",
                    text=text,
                    effect=SceneAspect.CONTACT,
                    bodies=part_numbers,
                )
        if has_walls:
            text = "is soft in MuJoCo (solref, solimp); a wall of a scene has the law in [contact]"
            yield Difference(kind="contact", text=text, effect=SceneAspect.CONTACT, differs=True)
