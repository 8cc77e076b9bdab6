"""Docstrings document the arguments and attributes that exist, each in an entry of its own."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SECTION = re.compile(r"[A-Z]\w+:$")
ENTRY = re.compile(r"(\*{0,2}\w+(?:, \*{0,2}\w+)*):(?:\s|$)")
PLAIN_BASES = {"NamedTuple", "Protocol", "TypedDict"}
"""Bases that add no attributes. Attributes of other bases are not known here."""


def entries(docstring, heading):
    """Return the first lines of the entries below a heading of a docstring."""
    lines, is_inside = [], False
    for line in docstring.splitlines():
        if line and not line.startswith(" "):
            is_inside = line == heading if SECTION.match(line) else False
        elif is_inside and re.match(r" {4}\S", line):
            lines.append(line.strip())
    return lines


def arguments_of(function):
    """Return the names of a function's arguments."""
    return {node.arg for node in ast.walk(function.args) if isinstance(node, ast.arg)}


def attributes_of(class_node):
    """Return the names that a class defines, sets or reads; None if it may inherit others."""
    if {ast.unparse(base) for base in class_node.bases} - PLAIN_BASES:
        return None
    names = set()
    for node in ast.walk(class_node):
        if isinstance(node, ast.Attribute):
            names.add(node.attr)
        elif isinstance(node, ast.AnnAssign | ast.Assign | ast.FunctionDef):
            targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", node)]
            names |= {getattr(target, "id", getattr(target, "name", "")) for target in targets}
    return names


def wrong_entries(source):
    """Return the entries of docstrings that are no arguments or attributes, or are lines of another entry."""
    faults = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.FunctionDef | ast.ClassDef):
            continue
        is_class = isinstance(node, ast.ClassDef)
        known_names = attributes_of(node) if is_class else arguments_of(node)
        for line in entries(ast.get_docstring(node) or "", "Attributes:" if is_class else "Args:"):
            entry = ENTRY.match(line)
            names = set(re.findall(r"\w+", entry[1])) if entry else set()
            if not entry or (known_names is not None and names - known_names):
                faults.append((node.name, line))
    return faults


@pytest.mark.parametrize("room", ["benchmarks", "docs/tools", "fmu_src", "packaging", "tests"])
def test_docstrings_have_an_entry_for_what_exists(room):
    wrong_names = {file.name: wrong_entries(file.read_text("utf-8")) for file in (ROOT / room).rglob("*.py")}
    assert {name: faults for name, faults in wrong_names.items() if faults} == {}


def test_a_wrong_entry_is_found():
    source = '''
def move(point, time):
    """Move.

    Args:
        pont: a point.
        time: a time, after
        which the point rests.
    """

class Span(NamedTuple):
    """A span.

    Attributes:
        start, end: its ends.
        size: its size.
    """

    start: float
    end: float
'''
    lines = [line for _, line in wrong_entries(source)]
    assert lines == ["pont: a point.", "which the point rests.", "size: its size."]
