"""Compiles an MJCF file with MuJoCo, with stand-ins if files that it names cannot be read.

A stand-in is a part that replaces a mesh, a picture or another part whose file cannot be read.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from chain_impact.conversion.differences import Difference, SceneAspect, collect_warnings
from chain_impact.scene.errors import SceneError

CORNERS = (0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
FACES = (0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
"""CORNERS, FACES: the tetrahedron that stands in for a mesh: x, y, z of each corner [m], and the indices of
the three corners of each face."""


class CompiledModel(NamedTuple):
    """A compiled MJCF file.

    Attributes:
        spec: the elements of the file.
        model: MuJoCo's compiled model.
        stand_ins: names of the meshes and other parts that stand-ins replace, and of deleted skins.
        differences: one for each file that cannot be read, and for each shape without the mass of its mesh.
    """

    spec: Any
    model: Any
    stand_ins: set[str]
    differences: list[Difference]


@contextmanager
def collect_mujoco_warnings(mujoco: Any) -> Iterator[list[str]]:
    """Context manager that yields a list, and at its end fills it with notes on MuJoCo's warnings.

    By itself MuJoCo writes a warning to the screen, and to a file in the current folder.
    """
    previous_handler = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: warnings.warn(text, stacklevel=2))
    try:
        with collect_warnings("MuJoCo") as notes:
            yield notes
    finally:
        mujoco.set_mju_user_warning(previous_handler)


def compile_model(mujoco: Any, path: Path) -> CompiledModel:
    """Read and compile an MJCF file; if MuJoCo refuses to compile, compile once more with stand-ins.

    Raises:
        SceneError: when MuJoCo cannot read the file, or refuses to compile with stand-ins, too, for example
            because a body gets its mass only from meshes whose files cannot be read.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        try:
            model, absent_files, massless_parts = spec.compile(), dict[str, str](), list[tuple[Any, str]]()
        except ValueError:
            spec = mujoco.MjSpec.from_file(str(path))
            absent_files = _stand_in(mujoco, spec, path)
            massless_parts = _clear_masses(mujoco, spec, absent_files)
            model = _compile_without(spec, massless_parts)
    except (ValueError, mujoco.FatalError) as error:
        raise SceneError(f"{path}: MuJoCo cannot read it: {error}") from None
    differences = [
        Difference(kind="file", name=name, text="cannot be read", effect=SceneAspect.NONE)
        for name in dict.fromkeys(absent_files.values())
    ]
    for body, mesh in massless_parts:
        text = f"without the mass of mesh {mesh}, of which the file {absent_files[mesh]} cannot be read"
        bodies, name = frozenset([body.id - 1, -1]), body.name or f"{body.id}"
        differences.append(
            Difference(kind="body", name=name, text=text, effect=SceneAspect.MASS, size=1.0, bodies=bodies)
        )
    return CompiledModel(spec, model, set(absent_files), differences)


def _stand_in(mujoco: Any, spec: Any, path: Path) -> dict[str, str]:
    """Replace each part of ``spec`` whose file is missing by a stand-in; delete a skin whose file is missing.

    This is done after MuJoCo has refused to compile ``spec``. If no file is missing, some file may have a
    fault; then all parts with files are replaced or deleted. Return the name of each such part → its file.
    """
    assets = [*spec.meshes, *spec.textures, *spec.hfields, *spec.skins]
    absent_assets = [asset for asset in assets if _file(asset) and not _file_exists(spec, path, _file(asset))]
    replaced: dict[str, str] = {}
    for asset in absent_assets or list(filter(_file, assets)):
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
    """Return the name of a part's file, or of the first of several files of a cube's texture; "" for none."""
    return str(asset.file or next(filter(None, getattr(asset, "cubefiles", ())), ""))


def _file_exists(spec: Any, path: Path, file: str) -> bool:
    folders = ("", spec.meshdir, spec.texturedir)
    return any((path.parent / folder / file).is_file() for folder in folders)


def _clear_masses(mujoco: Any, spec: Any, absent_files: dict[str, str]) -> list[tuple[Any, str]]:
    """Set the mass of each shape with an absent mesh to 0 if the body's mass follows from the body's shapes.

    The stand-in would give the body a wrong mass. Return a pair (body, name of the mesh) for each shape that
    loses its mass by this. ``absent_files`` has the names of the meshes that have stand-ins.
    """
    is_by_geometry = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    low, high = spec.compiler.inertiagrouprange
    bodies = []
    for geom in spec.geoms:
        is_given = bool(geom.parent.explicitinertial) and not is_by_geometry
        has_mass = geom.mass != 0.0 and geom.density != 0.0 and low <= geom.group <= high
        if geom.meshname in absent_files and has_mass and not is_given:
            geom.mass = 0.0
            bodies.append((geom.parent, geom.meshname))
    return bodies


def _compile_without(spec: Any, massless_parts: list[tuple[Any, str]]) -> Any:
    """Return the compiled model.

    If MuJoCo refuses a body because of its mass, the error names the meshes in ``massless_parts``, pairs
    (body, name of an absent mesh), which would give bodies their mass.
    """
    try:
        return spec.compile()
    except ValueError as error:
        if not massless_parts or "mass" not in str(error):
            raise
        meshes_text = ", ".join(dict.fromkeys(mesh for _, mesh in massless_parts))
        raise ValueError(f"a body has no mass but that of absent meshes: {meshes_text}") from None
