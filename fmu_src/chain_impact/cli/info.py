"""`chain-impact info`: print the contents of a scene or an FMU, or a list of models or laws."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from rich.text import Text

from chain_impact.cli.completers import is_fmu
from chain_impact.cli.options import Verbs, add_scene, add_verb
from chain_impact.cli.printing import out, say
from chain_impact.cli.screen import headline_lines, variable_lines
from chain_impact.fmu.importer import read_fmu
from chain_impact.fmu.platforms import platforms_of
from chain_impact.fmu.run import EXPERIMENT_SETTINGS
from chain_impact.fmu.scene_data import read_scene_data
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import load_scene
from chain_impact.variables.prepared import PreparedScene

LISTS: dict[str, Callable[[], dict[str, str]]] = {
    "models": lambda: {name: load_scene(name).description for name in model_names()},
    "laws": lambda: {law.id: law.source for law in CONTACT_LAWS.values()},
}
"""Name of a list that ``--list`` prints → function that returns name → text to print beside the name."""


def add(verbs: Verbs) -> None:
    """Add the verb ``info``, with its arguments and options, to the parser of the command line."""
    info = add_verb(
        verbs,
        "info",
        "list the values of a scene or an FMU under the names that --set takes, and the variables of its FMU",
        "pinned_arm",
    )
    add_scene(info, "scene or FMU")
    info.add_argument(
        "--list", choices=tuple(LISTS), help="list the models or the contact laws in place of a scene"
    )
    info.set_defaults(run=run, only_prints=True)


def run(options: argparse.Namespace) -> int:
    """Print the contents of a scene or an FMU or, with ``--list``, the models or laws; return 0."""
    if options.list:
        names = LISTS[options.list]()
        width = max(map(len, names))
        for name, text in names.items():
            say(f"{name:{width}}  {text}")
        return 0
    facts: list[tuple[str, object]] = []
    if is_fmu(options.source):
        fmu_data = read_fmu(Path(options.source))
        rules = read_scene_data(Path(options.source)).rules
        name, description, variables = fmu_data.modelName, fmu_data.description or "", fmu_data.modelVariables
        facts += [
            ("FMI version", fmu_data.fmiVersion),
            ("made by", fmu_data.generationTool),
            ("guid", fmu_data.guid),
        ]
        facts += [("platforms", ", ".join(platforms_of(options.source)))]
        if fmu_data.defaultExperiment:
            times = (fmu_data.defaultExperiment.stopTime, fmu_data.defaultExperiment.stepSize)
            facts += zip(EXPERIMENT_SETTINGS, times, strict=True)
        facts += [(v.name, _start_and_rule(v, rules)) for v in variables if v.causality == "parameter"]
    else:
        scene = load_scene(options.source)
        name, description, variables = scene.name, scene.description, PreparedScene(scene).variables
        # values that the list leaves out, because the headline shows them
        shown_fields = {"name", "description"}
        derived = scene.derived
        facts += [
            (
                name,
                f"{_rounded_value(value)}  # derived: {derived[name]}" if name in derived else _as_set(value),
            )
            for name, value in scene.values.items()
            if name not in shown_fields and value not in (None, "", ())
        ]
    out.print(Text.assemble((name, "bold"), f"  {description}"), soft_wrap=True)
    for key, value in facts:
        say(f"  {key} = {value}")
    out.print(headline_lines("Variables of the FMU"))
    for line in variable_lines(variables, out.width):
        say(line)
    return 0


def _as_set(value: object) -> object:
    """Return a value of a scene in a form whose text ``--set`` accepts."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and "e" in (short_text := f"{value:g}") and float(short_text) == value:
        return short_text
    return list(value) if isinstance(value, tuple) else value


def _start_and_rule(variable: Any, rules: Mapping[str, str]) -> object:
    """Return the text for a parameter of an FMU: the start value and, for a name in ``rules``, the rule.

    ``rules`` is name of a derived parameter → how the value follows from other parameters, in words.
    """
    rule = rules.get(variable.name)
    return f"{_rounded_value(float(variable.start))}  # derived: {rule}" if rule else _start(variable)


def _rounded_value(value: object) -> object:
    """Return a derived value for printing: a real number with at most 15 significant digits.

    Any other value is returned in a form whose text ``--set`` accepts.
    """
    return f"{value:.15g}" if isinstance(value, float) else _as_set(value)


def _start(variable: Any) -> object:
    """Return the start value of an FMU's parameter for printing; for an enumeration, the choice's name."""
    if variable.type in ("Real", "Float64"):
        # in FMI 3.0, the start value of an array is a text of several numbers, which is printed unchanged
        with suppress(ValueError):
            return _as_set(float(variable.start))
    if variable.type != "Enumeration":
        return variable.start
    names = {str(item.value): item.name for item in variable.declaredType.items}
    return names.get(str(variable.start), variable.start)
