"""Names that the package defines: each stands for one thing, and says what it is."""

import ast
from collections import Counter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "fmu_src" / "chain_impact"
MODULES = sorted(PACKAGE.rglob("*.py"))


def constants(file):
    """Yield the name of each constant as often as a file defines it."""
    for node in ast.parse(file.read_text("utf-8")).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        nodes = (part for target in targets if target for part in ast.walk(target))
        yield from {part.id for part in nodes if isinstance(part, ast.Name) and part.id.isupper()}


def numbers(file):
    """Yield the name of each constant of a file that is a number, or a tuple of numbers, without other
    names."""
    node_types = (ast.Tuple, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop, ast.Constant, ast.Load)
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.Assign):
            parts = [*ast.walk(node.value)]
            kinds = {type(part.value) for part in parts if isinstance(part, ast.Constant)}
            if all(isinstance(part, node_types) for part in parts) and kinds <= {int, float}:
                yield from {
                    name_node.id for name_node in ast.walk(node.targets[0]) if isinstance(name_node, ast.Name)
                }


def test_no_two_files_define_a_number_of_the_same_name():
    counts = Counter(name for file in PACKAGE.rglob("*.py") for name in numbers(file) if name.isupper())
    assert counts
    assert {name for name, count in counts.items() if count > 1} == set()


ROOMS_OF_NAMES = {
    room: [file for file in MODULES if file.relative_to(PACKAGE).parts[0] == room]
    for room in sorted({file.relative_to(PACKAGE).parts[0] for file in MODULES})
}
"""Room or single module of the package → its files."""
ROOMS = sorted({file.parent.name for file in PACKAGE.glob("*/__init__.py")} - {"compilation"})


@pytest.mark.parametrize("room", ROOMS)
def test_no_two_files_of_a_room_define_a_constant_of_the_same_name(room):
    """In the kernel, a single file may not define a constant twice either."""
    names = list if room == "kernel" else set
    counts = Counter(name for file in (PACKAGE / room).rglob("*.py") for name in names(constants(file)))
    assert counts
    assert {name for name, count in counts.items() if count > 1} == set()


def test_no_two_files_define_a_class_of_the_same_name():
    counts = Counter(
        node.name
        for file in PACKAGE.rglob("*.py")
        for node in ast.parse(file.read_text("utf-8")).body
        if isinstance(node, ast.ClassDef)
    )
    assert counts
    assert {name for name, count in counts.items() if count > 1} == set()


SHARED_FUNCTION_NAMES = {
    "add": "each command adds its arguments to the parser",
    "run": "each command executes its options",
    "main": "the entry of a program",
}
"""Name that several modules give a public function → reason."""


def test_no_two_files_define_a_public_function_of_the_same_name():
    """The kernel has rules for dual numbers of the same names, and files whose text names the compiled
    kernels are exempt, too."""
    exempt_rooms = {"kernel", "compilation", "user_laws", "packaging"}
    counts = Counter(
        node.name
        for room, files in ROOMS_OF_NAMES.items()
        if room not in exempt_rooms
        for file in files
        for node in ast.parse(file.read_text("utf-8")).body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    )
    assert {name for name, count in counts.items() if count > 1} == {*SHARED_FUNCTION_NAMES}


PREPOSITIONS = {
    *("above", "across", "after", "against", "along", "among", "around", "at", "before", "behind", "below"),
    *(
        "beside",
        "between",
        "beyond",
        "by",
        "for",
        "in",
        "near",
        "of",
        "off",
        "over",
        "past",
        "per",
        "through",
    ),
    *("until", "within"),
}
IDIOMS = {"as", "from", "on", "to", "with", "without"}
"""A function may begin so: ``as_x``, ``from_x`` and ``to_x`` convert, ``on_x`` is called at an event x, and
``with_x`` and ``without_x`` return a changed copy."""


def begins_with(name, words):
    """Return whether the first word of a name is one of ``words``."""
    return name.strip("_").lower().split("_")[0] in words


@pytest.mark.parametrize("room", [room for room in ROOMS_OF_NAMES if room != "kernel"])
def test_no_name_begins_with_a_preposition(room):
    """A name that begins so, such as of_robot, does not say what the function returns."""
    misnamed = set()
    for file in ROOMS_OF_NAMES[room]:
        code = ast.walk(ast.parse(file.read_text("utf-8")))
        names = [node.name for node in code if isinstance(node, (ast.FunctionDef, ast.ClassDef))]
        misnamed |= {name for name in names if begins_with(name, PREPOSITIONS)}
        fixed = [file.stem, *constants(file)]
        misnamed |= {name for name in fixed if begins_with(name, PREPOSITIONS | IDIOMS)}
    assert misnamed == set()
