"""The declared writers of the record's fields, against the kernel modules that write the fields.

A write is an assignment to a field of the instance ``d`` or ``t``, or of a named part of the instance. If a
function fills an argument, its caller is the writer.
"""

import ast
from collections import defaultdict
from pathlib import Path

import pytest

import chain_impact.kernel
from chain_impact.kernel.record.fields import WRITERS
from chain_impact.kernel.record.instance import instance_dtype

KERNEL = Path(chain_impact.kernel.__file__).parent
LAYOUT = instance_dtype(2, 2, 4)
PARTS = {name for name in LAYOUT.names if LAYOUT[name].base.names}
MODULES = sorted(
    file.relative_to(KERNEL).as_posix() for file in KERNEL.rglob("*.py") if "record" not in file.parts
)
# fields with several writers: scratch memory and results of a method's functions (ode/step_control.py)
SHARED = {
    "candidate.offset",  # one module sets walls at rest, the other sets moving walls
    "step.dense",
    "search.curvature",
    "trial.state",
    "scratch.applied_force",
    *(f"implicit.{name}" for name in ("z_scratch", "stages", "right_hand_sides", "target_clearance")),
}


def pairs(target, value):
    """Return the single assignments of an assignment with several targets."""
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        return [pair for two in zip(target.elts, value.elts, strict=True) for pair in pairs(*two)]
    if isinstance(target, ast.Tuple):
        return [(element, None) for element in target.elts]
    return [(target, value)]


def assignments(function):
    for node in ast.walk(function):
        if isinstance(node, ast.Assign):
            yield from (pair for target in node.targets for pair in pairs(target, node.value))
        elif isinstance(node, ast.AugAssign):
            yield node.target, None


def way(node):
    """Return the names of an attribute chain: d.contacts.event[c] has d, contacts, event."""
    names = []
    while isinstance(node, (ast.Attribute, ast.Subscript)):
        if isinstance(node, ast.Attribute):
            names.append(node.attr)
        node = node.value
    return [node.id, *reversed(names)] if isinstance(node, ast.Name) else []


def writes(function):
    """Yield the (instance, part, field) that a function assigns to."""
    parts_of = {part: ["d", part] for part in PARTS & {argument.arg for argument in function.args.args}}
    parts_of |= {"d": ["d"], "t": ["t"]}
    for target, value in sorted(assignments(function), key=lambda pair: pair[0].lineno):
        names = way(target if value is None or not isinstance(target, ast.Name) else value)
        if not names or names[0] not in parts_of:
            continue
        names = parts_of[names[0]] + names[1:]
        if isinstance(target, ast.Name):
            parts_of[target.id] = names
        elif len(names) > 2 and names[1] in PARTS:
            yield names[0], names[1], names[2]


@pytest.fixture(scope="module")
def writers():
    """Return each written field with its writing modules, separately for the tangent instances."""
    ordinary, tangent = defaultdict(set), defaultdict(set)
    for module in MODULES:
        for function in ast.walk(ast.parse((KERNEL / module).read_text(encoding="utf-8"))):
            if isinstance(function, ast.FunctionDef):
                for instance, part, field in writes(function):
                    writers_of_fields = tangent if module.startswith("tangent/") else ordinary
                    writers_of_fields[f"{part}.{field}"].add((instance, module))
    return ordinary, tangent


def declared(name):
    part, field = name.split(".")
    return WRITERS[part].get(field, WRITERS[part][""])


def test_every_part_declares_its_writers():
    assert set(WRITERS) >= PARTS
    for part in PARTS:
        fields = set(LAYOUT[part].base.names)
        assert set(WRITERS[part]) - {""} <= fields, part


def test_each_field_is_written_by_its_declared_writers_only(writers):
    ordinary, _ = writers
    strangers = {
        name: sorted({module for _, module in modules} - set(declared(name)))
        for name, modules in ordinary.items()
        if not {module for _, module in modules} <= set(declared(name))
    }
    assert strangers == {}
    assert len(ordinary) > 200


def test_a_field_has_one_writer_but_for_work_space_and_what_methods_return():
    names = {f"{part}.{field}" for part in PARTS for field in LAYOUT[part].base.names}
    assert {name for name in names if len(declared(name)) > 1} == SHARED


def test_every_declared_writer_writes_its_fields(writers):
    ordinary, _ = writers
    for part in PARTS:
        for field, declared in WRITERS[part].items():
            field_names = LAYOUT[part].base.names
            names = {
                f"{part}.{field_name}"
                for field_name in ([field] if field else set(field_names) - set(WRITERS[part]))
            }
            writers_of_names = [modules for name, modules in ordinary.items() if name in names]
            assert set(declared) <= {module for modules in writers_of_names for _, module in modules}, (
                part,
                field,
            )


def test_derivatives_change_nothing_in_the_run_itself(writers):
    """kernel/tangent/ writes to tangent instances only."""
    _, tangent = writers
    assert {
        name for name, modules in tangent.items() if any(instance == "d" for instance, _ in modules)
    } == set()
    assert "step.state_end" in tangent


def test_every_form_of_a_write_is_found():
    source = """
def f(d, law, y):
    own, n = d.contacts, d.link_count
    latest = d.latest
    own.event[0], latest.onset[n] = 1, 2.0
    law.number[0] += 1
    y[0] = d.step.end = 3.0
    again = own
    again.onset[0] = 1.0
"""
    function = ast.parse(source).body[0]
    assert {f"{part}.{field}" for _, part, field in writes(function)} == {
        "contacts.event",
        "latest.onset",
        "law.number",
        "step.end",
        "contacts.onset",
    }
