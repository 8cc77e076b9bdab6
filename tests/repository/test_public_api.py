"""Public names, used by other people's files: new names may come, but none may go or change.

These are the keys of scenes, variables of FMUs, contact laws, commands and options, and what is exported,
with the attributes of exported classes, also deprecated ones. All else may change until version 1.0.
``public_api.txt`` has the names; the command ``python tests/repository/test_public_api.py`` adds new ones,
and writes ``__init__.pyi``, in which type checkers find what is exported.
"""

import argparse
import dis
import re
import sys
from pathlib import Path

import pytest

import chain_impact
from chain_impact import cli
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import load_scene, scene_from_dict, scene_keys
from chain_impact.variables.prepared import PreparedScene

FILE = Path(__file__).with_name("public_api.txt")
STUB = Path(chain_impact.__file__).with_suffix(".pyi")
BODIES = {
    "name": "Cart",
    "chain": {
        "base": "slider",
        "slider": {"min": -1.0, "max": 1.0, "force_limit": 9.0, "friction": 1.0},
        "links": [
            {"length": 1.0, "mass": 1.0, "center_of_mass_offset": 0.1, "points": [{"x": 0.5, "y": 0.1}]},
        ],
    },
    "box": {"y_min": -9.0},
    "contact": {"points": []},
    "initial": {"angles": [0.0]},
    "inputs": {"slider_force": True},
    "outputs": {"loads": True},
}
"""A scene with a slider, and a link with an offset of its centre of mass and a point."""
DRIVES = {"link[2].joint_armature": 0.1, "link[2].joint_torque_limit": 9.0, "inputs.joint_targets": True}
"""Values that give the joints of a scene drives."""
HINT = "run: python tests/repository/test_public_api.py"


def command_line():
    verbs = next(a.choices for a in cli.parser()._actions if isinstance(a, argparse._SubParsersAction))
    for verb, parser in verbs.items():
        yield f"command: {verb}"
        for action in parser._actions:
            yield from (f"command: {verb} {option}" for option in action.option_strings)


def attributes(exported):
    """Return the public attributes of a class that this package defines, also those set in ``__init__``."""
    attribute_names = set()
    for base in exported.__mro__ if isinstance(exported, type) else ():
        if base.__module__.startswith("chain_impact"):
            attribute_names |= {*vars(base), *getattr(base, "__annotations__", {})}
            code = getattr(vars(base).get("__init__"), "__code__", compile("", "", "exec"))
            attribute_names |= {
                instruction.argval
                for instruction in dis.get_instructions(code)
                if instruction.opname == "STORE_ATTR"
            }
    return {name for name in attribute_names if not name.startswith("_")}


def names():
    """Yield every public name as a line."""
    for name in chain_impact.__all__:
        yield f"python: {name}"
        yield from (f"python: {name}.{attribute}" for attribute in attributes(getattr(chain_impact, name)))
    yield from (f"scene key: {key}" for key, entry in scene_keys())
    yield from (f"contact law: {law.number} {law.id}" for law in CONTACT_LAWS.values())
    yield from command_line()
    driven_arm = load_scene("pinned_arm").with_values(DRIVES)
    cart = scene_from_dict(BODIES, "cart")
    following = cart.with_values({"inputs.joint_targets": True})
    for scene in (*map(load_scene, model_names()), driven_arm, cart, following):
        kinds = {re.sub(r"\[\d+\]", "[i]", variable.name) for variable in PreparedScene(scene).variables}
        yield from (f"FMU variable: {kind}" for kind in kinds)


def test_public_names_are_listed_and_none_is_removed_or_changed():
    listed, public = set(FILE.read_text(encoding="utf-8").splitlines()), set(names())
    assert listed - public == set(), "removed or changed"
    assert public - listed == set(), f"new: {HINT}"


def stub():
    """Return the text of STUB: an import for each public name."""
    stub_text = "# Made by tests/repository/test_public_api.py from the table in __init__.py.\n"
    lines = [f"from {home} import {name} as {name}\n" for name, home in chain_impact._HOMES.items()]
    return stub_text + "".join(sorted(lines))


def test_type_checkers_find_the_names_that_programs_do():
    assert STUB.with_name("py.typed").is_file()
    assert STUB.read_text(encoding="utf-8") == stub(), HINT
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        chain_impact.simulat  # noqa: B018


def main() -> int:
    """Write STUB, and add the new names to the file; refuse to remove names."""
    listed = set(FILE.read_text(encoding="utf-8").splitlines()) if FILE.exists() else set()
    if gone := sorted(listed - set(names())):
        print("removed or changed, not written:", *gone, sep="\n", file=sys.stderr)
        return 1
    STUB.write_text(stub(), encoding="utf-8")
    FILE.write_text("".join(f"{name}\n" for name in sorted(set(names()))), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
