"""Names that other people's files use: they may be added to, never removed or changed.

``public_api.txt`` has them all. ``python tests/test_public_api.py`` adds what is new.
"""

import argparse
import dataclasses
import inspect
import re
import sys
from pathlib import Path
from types import FunctionType

import chain_impact
from chain_impact import cli
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.results.impacts import IMPACT_DTYPE
from chain_impact.scene.scene import load_scene, model_names, scene_keys
from chain_impact.variables.model import Model

FILE = Path(__file__).with_name("public_api.txt")
HINT = "run: python tests/test_public_api.py"


def described(name, function):
    """A function, and each of its parameters with its place or name and its default."""
    yield f"{name}()"
    parameters = [one for one in inspect.signature(function).parameters.values() if one.name != "self"]
    for place, parameter in enumerate(parameters, 1):
        default = parameter.default
        shown = default.__name__ if callable(default) and default is not parameter.empty else repr(default)
        ending = "" if default is parameter.empty else f" = {shown}"
        kind = "keyword" if parameter.kind is parameter.KEYWORD_ONLY else f"argument {place}"
        yield f"{name}() {kind}: {parameter.name}{ending}"


def python_names():
    for name in chain_impact.__all__:
        thing = getattr(chain_impact, name)
        if inspect.isclass(thing):
            yield f"python: class {name}({', '.join(base.__name__ for base in thing.__bases__)})"
            yield from (f"python: {name}.{member}" for member in members(thing))
        elif callable(thing):
            yield from (f"python: {line}" for line in described(name, thing))
        else:
            yield f"python: {name}"
    yield from (f"python: Result.impacts[{column!r}]" for column in IMPACT_DTYPE.names)


def members(kind):
    """The public attributes, properties and methods that a class of the package adds."""
    fields = {entry.name for entry in dataclasses.fields(kind)} if dataclasses.is_dataclass(kind) else set()
    own = {name for base in kind.__mro__ if base.__module__.startswith("chain_impact") for name in vars(base)}
    for name in sorted(fields | own):
        if not name.startswith("_"):
            is_method = isinstance(inspect.getattr_static(kind, name, None), FunctionType)
            yield from described(name, getattr(kind, name)) if is_method else [name]


def command_line():
    verbs = next(a.choices for a in cli.parser()._actions if isinstance(a, argparse._SubParsersAction))
    for verb, parser in verbs.items():
        yield f"command: {verb}"
        for action in parser._actions:
            yield from (f"command: {verb} {option}" for option in action.option_strings)


def names():
    """Every public name, a line each."""
    yield from python_names()
    yield from (f"scene key: {key}" for key, entry in scene_keys())
    yield from (f"contact law: {law.number} {law.id}" for law in CONTACT_LAWS.values())
    yield from (f"status: {code}" for code in STATUS_TEXT)
    yield from command_line()
    yield from (f"model: {name}" for name in model_names())
    for scene in map(load_scene, model_names()):
        kinds = {re.sub(r"\[\d+\]", "[i]", variable.name) for variable in Model(scene).variables}
        yield from (f"FMU variable: {kind}" for kind in kinds)


def test_nothing_public_is_removed_or_changed():
    missing = sorted(set(FILE.read_text(encoding="utf-8").splitlines()) - set(names()))
    assert not missing, "removed or changed: " + "; ".join(missing)


def test_every_public_name_is_listed():
    new = sorted(set(names()) - set(FILE.read_text(encoding="utf-8").splitlines()))
    assert not new, f"new, {HINT}: " + "; ".join(new)


def test_every_exported_name_is_documented():
    page = (Path(__file__).parents[1] / "docs" / "python_api.md").read_text(encoding="utf-8")
    missing = [name for name in chain_impact.__all__ if f".{name}" not in page]
    assert not missing


def main() -> int:
    """Add the new names to the file; refuse to take any away."""
    listed = set(FILE.read_text(encoding="utf-8").splitlines()) if FILE.exists() else set()
    if gone := sorted(listed - set(names())):
        print("removed or changed, not written:", *gone, sep="\n", file=sys.stderr)
        return 1
    FILE.write_text("".join(f"{name}\n" for name in sorted(set(names()))), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
