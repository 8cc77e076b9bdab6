"""The rooms of the package, its folders, and which of them import which: from the imports themselves."""

import ast
from collections import defaultdict
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "fmu_src" / "chain_impact"
KERNEL = PACKAGE / "kernel"


def room_of(module: Path, inside: Path) -> str:
    """The room of a module: its folder, or the module itself where it stands in none."""
    steps = module.relative_to(inside).with_suffix("").parts
    if inside == PACKAGE and steps[0] == "kernel":
        return "kernel"
    return "/".join(steps[:-1]) or steps[0]


def module_of(name: str) -> Path | None:
    """The file of a module or package of ours, by its dotted name; None for anything else."""
    own, *steps = name.split(".")
    place = PACKAGE.joinpath(*steps)
    files = (place.with_suffix(".py"), place / "__init__.py")
    return next((file for file in files if own == PACKAGE.name and file.is_file()), None)


def imported(file: Path) -> set[Path]:
    """The modules of the package that a file imports, wherever in it."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            whole = str(node.module)
            found |= {module_of(f"{whole}.{one.name}") or module_of(whole) for one in node.names}
    return {module for module in found if module}


def arrows(inside: Path) -> dict[str, set[str]]:
    """Room → the other rooms that its modules import, in the package or in its kernel."""
    found: dict[str, set[str]] = defaultdict(set)
    for file in sorted(inside.rglob("*.py")):
        if file.parent == inside and file.name == "__init__.py":
            continue
        room = room_of(file, inside)
        others = {room_of(one, inside) for one in imported(file) if one.is_relative_to(inside)}
        found[room] |= others - {room, "__init__"}
    return found


def rows(inside: Path) -> list[tuple[str, str]]:
    """A row for each room: its name, and what it imports."""
    found = arrows(inside)
    return [(f"`{room}`", ", ".join(sorted(found[room])) or "—") for room in sorted(found)]
