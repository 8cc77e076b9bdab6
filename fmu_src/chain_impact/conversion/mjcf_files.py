"""Compiles an MJCF file with MuJoCo, if necessary with stand-ins for files that are missing.

A stand-in is a part that replaces a mesh, a picture or another part whose file is missing.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from chain_impact.conversion.differences import Difference, Effect, collected_warnings
from chain_impact.scene.reading import SceneError

CORNERS = (0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
FACES = (0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
"""The faces of the tetrahedron that stands in for a missing mesh, each as the indices of three of its
CORNERS."""


class Compiled(NamedTuple):
    """A compiled MJCF file.

    Attributes:
        spec: the elements of the file.
        model: MuJoCo's compiled model.
        stand_ins: names of the meshes and other parts that stand-ins replace, and of deleted skins.
        differences: the files that could not be read, bodies without a mesh's mass, and MuJoCo's warnings.
    """

    spec: Any
    model: Any
    stand_ins: set[str]
    differences: list[Difference]


def compiled(mujoco: Any, path: Path) -> Compiled:
    """Return an MJCF file, compiled.

    Raises:
        SceneError: when MuJoCo cannot read the file, or a body would get all its mass from a missing mesh.
    """
    try:
        with collected_warnings("MuJoCo") as differences:
            spec = mujoco.MjSpec.from_file(str(path))
            try:
                model, absent, weightless = spec.compile(), dict[str, str](), list[tuple[Any, str]]()
            except ValueError:
                spec = mujoco.MjSpec.from_file(str(path))
                absent = _stand_in(mujoco, spec, path)
                weightless = _weightless(mujoco, spec, absent)
                model = _compiled_without(spec, weightless)
    except (ValueError, mujoco.FatalError) as error:
        raise SceneError(f"{path}: MuJoCo cannot read it: {error}") from None
    differences += [
        Difference(kind="file", name=name, text="cannot be read; nothing needs it", effect=Effect.NONE)
        for name in dict.fromkeys(absent.values())
    ]
    for body, mesh in weightless:
        text = f"without the mass of mesh {mesh}, of which the file {absent[mesh]} cannot be read"
        bodies, name = frozenset([body.id - 1, -1]), body.name or f"{body.id}"
        differences.append(
            Difference(kind="body", name=name, text=text, effect=Effect.MASS, size=1.0, bodies=bodies)
        )
    return Compiled(spec, model, set(absent), differences)


def _stand_in(mujoco: Any, spec: Any, path: Path) -> dict[str, str]:
    """Replace each part whose file is missing by a stand-in, after MuJoCo has refused to compile the whole.

    A skin is deleted. If no file is missing, some file has a fault; then all parts with files are replaced.
    Return name of each replaced or deleted part → its file.
    """
    assets = [*spec.meshes, *spec.textures, *spec.hfields, *spec.skins]
    absent = [asset for asset in assets if _file(asset) and not _found(spec, path, _file(asset))]
    replaced: dict[str, str] = {}
    for asset in absent or list(filter(_file, assets)):
        file = _file(asset)
        replaced[asset.name or Path(file).stem] = file
        asset.name = asset.name or Path(file).stem
        if asset in spec.meshes:
            asset.file, asset.uservert, asset.userface = "", CORNERS, FACES
            asset.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        elif asset in spec.textures:
            asset.file, asset.builtin = "", mujoco.mjtBuiltin.mjBUILTIN_FLAT
            asset.cubefiles = [""] * len(asset.cubefiles)
            asset.width, asset.height = 8, 8 if asset.type == mujoco.mjtTexture.mjTEXTURE_2D else 48
        elif asset in spec.hfields:
            asset.file, asset.nrow, asset.ncol, asset.userdata = "", 2, 2, [0.0] * 4
        else:
            spec.delete(asset)
    return replaced


def _file(asset: Any) -> str:
    """Return the file of a part, or "" if it has none; of a cube with several pictures, the first file."""
    return str(asset.file or next(filter(None, getattr(asset, "cubefiles", ())), ""))


def _found(spec: Any, path: Path, file: str) -> bool:
    folders = ("", spec.meshdir, spec.texturedir)
    return any((path.parent / folder / file).is_file() for folder in folders)


def _weightless(mujoco: Any, spec: Any, absent: dict[str, str]) -> list[tuple[Any, str]]:
    """Set the mass of each shape with a missing mesh to 0 if the mass of its body follows from its shapes.

    The stand-in would give the body a wrong mass. Return the bodies that lose mass by this, each with the
    name of the mesh.
    """
    by_geometry = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    low, high = spec.compiler.inertiagrouprange
    bodies = []
    for geom in spec.geoms:
        given = bool(geom.parent.explicitinertial) and not by_geometry
        weighs = geom.mass != 0.0 and geom.density != 0.0 and low <= geom.group <= high
        if geom.meshname in absent and weighs and not given:
            geom.mass = 0.0
            bodies.append((geom.parent, geom.meshname))
    return bodies


def _compiled_without(spec: Any, weightless: list[tuple[Any, str]]) -> Any:
    """Return the compiled model.

    If MuJoCo refuses a body because it has no mass, the error names the missing meshes that would give the
    mass.
    """
    try:
        return spec.compile()
    except ValueError as error:
        if not weightless or "mass" not in str(error):
            raise
        meshes = ", ".join(dict.fromkeys(mesh for _, mesh in weightless))
        raise ValueError(f"a body has no mass but that of absent meshes: {meshes}") from None
