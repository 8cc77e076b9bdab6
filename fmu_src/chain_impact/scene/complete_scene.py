"""The completion of a scene after reading: values that follow from other keys, contents of table files."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from chain_impact.scene.checks.rule_checks import check_given_rules
from chain_impact.scene.contents import AnyScene
from chain_impact.scene.errors import error_at, no_wall_error
from chain_impact.scene.half_planes import direction
from chain_impact.scene.keys.tables import Material
from chain_impact.scene.shapes import with_shapes
from chain_impact.scene.signals import with_signals
from chain_impact.text import names_text
from chain_impact.user_laws.law_file import LawError, read_law

ANGLES = ("initial", "angles")
NAMED_FUNCTIONS = 3  # largest number of functions of a law file that an error names


def completed_scene(scene: AnyScene, folder: Path) -> AnyScene:
    """Return the scene with all values that follow from other keys, and with the contents of table files.

    Relative paths of files begin at ``folder``.
    """
    scene = with_law_path(scene, folder)
    check_given_rules(scene)
    scene = with_radii(with_shapes(with_angles(scene)))
    return with_signals(with_materials(with_absolute_angles(scene)), folder)


def with_law_path(scene: AnyScene, folder: Path) -> AnyScene:
    """Return the scene with ``contact.law_file`` as absolute path; a relative path begins at ``folder``.

    A scene without such a file is returned unchanged; a file that has no valid law is refused.
    """
    file = scene.contact.law_file
    if not file:
        return scene
    path = (folder / file).absolute()
    try:
        read_law(path)
    except LawError as error:
        requirement = f"{error}{_other_name_hint(path, _function_names(path))}"
        raise error_at(("contact", "law_file"), requirement, repr(file)) from None
    return replace(scene, contact=replace(scene.contact, law_file=str(path)))


def misnamed_law_hint(data: Any, value: str, folder: Path) -> str:
    """Return a hint if the refused contact model ``value`` is a function of the scene's law file; else "".

    Args:
        data: the data of the scene file.
        value: the text of the refused model, as in Python.
        folder: the folder at which a relative path of the law file begins.
    """
    contact = data.get("contact") if isinstance(data, Mapping) else None
    file = contact.get("law_file") if isinstance(contact, Mapping) else None
    if not isinstance(file, str):
        return ""
    path = folder / file
    return _other_name_hint(path, [name for name in _function_names(path) if repr(name) == value])


def _other_name_hint(path: Path, names: Sequence[str]) -> str:
    """Return a hint that ``names`` of functions in a law's file differ from its own; "" if none does."""
    if not names or path.stem in names:
        return ""
    names_in_file = names_text(names, NAMED_FUNCTIONS)
    return f"; {path.name} defines {names_in_file}: file, function and model must have one name"


def _function_names(path: Path) -> list[str]:
    """Return the names of the functions that a Python file defines; [] if it cannot be read."""
    try:
        tree = ast.parse(path.read_text(encoding="utf-8"))
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    return [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]


def with_angles(scene: AnyScene) -> AnyScene:
    """Return the scene with an angle for each entry of ``walls``; a given normal becomes None."""
    walls = (
        replace(wall, angle=direction(wall.normal), normal=None) if wall.normal else wall
        for wall in scene.walls
    )
    return replace(scene, walls=tuple(walls))


def with_radii(scene: AnyScene) -> AnyScene:
    """Return the scene with a radius for each additional point of a link.

    A point without a given radius gets ``contact.radius``, and this radius counts as derived.
    """
    links, paths = [], [*scene.derived_paths]
    for i, link in enumerate(scene.chain.links):
        points = []
        for j, site in enumerate(link.points):
            if site.radius is None:
                paths.append(("chain", "links", i, "points", j, "radius"))
                points.append(replace(site, radius=scene.contact.radius))
            else:
                points.append(site)
        links.append(replace(link, points=tuple(points)) if points else link)
    if not scene.chain.sites:
        return scene
    chain = replace(scene.chain, links=tuple(links))
    return replace(scene, chain=chain, derived_paths=tuple(sorted(paths, key=str)))


def with_absolute_angles(scene: AnyScene) -> AnyScene:
    """Return the scene with absolute initial angles only, without joint angles.

    If the file gives joint angles, the absolute angles that follow from them count as given.
    """
    start, paths = scene.initial, scene.derived_paths
    if start.joint_angles is None:
        return scene
    paths = tuple(path for path in paths if path != ANGLES)
    absolute = replace(start, joint_angles=None)
    return replace(scene, initial=absolute, derived_paths=paths, has_joint_angles=True)


def with_materials(scene: AnyScene) -> AnyScene:
    """Return the scene with a material, a table of [contact.wall], for each existing wall.

    If the file does not give a key of this table, the key is None in the material; ``Material`` tells which
    value applies then. A material for a wall that does not exist is refused.
    """
    given_materials = dict(scene.contact.wall)
    materials = {name: given_materials.pop(name, Material()) for name in scene.half_planes}
    if given_materials:
        raise no_wall_error(("contact", "wall", next(iter(given_materials))), materials)
    return replace(scene, contact=replace(scene.contact, wall=materials))
