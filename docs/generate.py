"""Fill the tables of the docs from the code: ``python docs/generate.py``.

The script replaces the text between ``<!-- generated: name -->`` and ``<!-- end -->`` in a page by the result
of the function ``name`` below. The script also writes the JSON schema of scene files, ``scene.schema.json``.
"""

from __future__ import annotations

import dataclasses
import json
import re
import sys
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, get_args, get_origin

from command_help import command_line
from scene_schema import schema

from chain_impact import sphere_plane_stiffness
from chain_impact.kernel.forces.laws import CONTACT_LAWS, ContactLaw
from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.kernel.status import STATUS_NAME, STATUS_TEXT
from chain_impact.scene.limits import Derived, allowed, without_none
from chain_impact.scene.names import AXES, INPUTS_OF
from chain_impact.scene.reading import entry_type
from chain_impact.scene.scene import load_scene, scene_keys
from chain_impact.variables.kind import ALWAYS, LINE, Kind
from chain_impact.variables.listing import choices_of
from chain_impact.variables.outputs import INPUTS, OUTPUTS
from chain_impact.variables.parameters import METHODS, PARAMETERS
from chain_impact.variables.shape import OF_STOPS

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.fmu.planted_faults import FAULTS, FOUND, WHOLE

DOCS = Path(__file__).parent
SCHEMA = DOCS / "scene.schema.json"
BLOCK = re.compile(r"(?<=^<!-- generated: )(\w+)( -->\n).*?(?=^<!-- end -->$)", re.MULTILINE | re.DOTALL)
RADIUS = 0.02  # m, radius of the spheres in the table of stiffness
# typical Young's modulus [Pa] and Poisson's ratio of each material
MATERIALS = {
    "steel": (207e9, 0.3),
    "aluminium": (70e9, 0.33),
    "PMMA": (3.0e9, 0.38),
    "nylon": (2.7e9, 0.39),
    "rubber": (5e6, 0.49),
}


def filled(page: str) -> str:
    """Return the text of a page with tables from the code."""
    return BLOCK.sub(lambda found: f"{found[1]}{found[2]}\n{TABLES[found[1]]()}\n\n", page)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in (head, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def code(text: object) -> str:
    """Return a text as inline code; empty for an empty text."""
    return f"`{text}`" if text not in ("", None) else ""


# ---- scene ----------------------------------------------------------------------------------------------


def scene_reference() -> str:
    """Return one list for each table of the scene file."""
    sections: dict[str, list[Sequence[str]]] = {}
    for key, entry in scene_keys():
        section, _, name = key.rpartition(".")
        rows = sections.setdefault(section, [])
        if entry.metadata and not _is_table(entry.type):
            rule = entry.metadata
            meaning, _, missing = _of_the_joint(rule["description"]).partition("; if missing: ")
            default = missing or _default(rule["default"])
            if default == AS_IN_CONTACT:  # the allowed values and the meaning are the same, too
                rows.append((code(name), default, ""))
            else:
                rows.append((code(name), _value(default, _allowed(entry.type, rule)), meaning))
    blocks = []
    for section, rows in sections.items():
        if rows:
            title = f"[[{section[:-2]}]]" if section.endswith("[]") else f"[{section}]"
            heading = f"### `{title}`" if section else "### Top level"
            blocks.append(f"{heading}\n\n" + "\n".join(_joined(rows)))
    return "\n\n".join(blocks)


SHORT = 5  # words of a meaning
AS_IN_CONTACT = "as in [contact]"  # default of keys that also exist in [contact]


def _joined(rows: Iterable[Sequence[str]]) -> Iterable[str]:
    """Return one line for each key, or for adjacent keys with short meanings and equal values."""
    for _, group in groupby(rows, lambda row: (row[1], len(row[2].split()) > SHORT and row[0])):
        keys, values, meanings = zip(*group, strict=True)
        value = f" ({values[0]})" if values[0] else ""
        meaning = ", ".join(filter(None, meanings))
        yield f"- {', '.join(keys)}{value}" + (f": {meaning}" if meaning else "")


def _value(default: str, allowed: str) -> str:
    """Return the default with its unit, and the range. A default among choices is bold."""
    if default and default in allowed.split(", "):
        return allowed.replace(default, f"**{default}**", 1)
    limits, unit = re.fullmatch(r"(.*?) ?(\[[^,]*\])?", allowed).groups("")
    if "each" in limits:  # the unit of the items
        return ", ".join(filter(None, (default, allowed)))
    return ", ".join(filter(None, (f"{default} {unit}".strip(), limits)))


def _of_the_joint(description: str) -> str:
    """Return a description without "of the joint nearer to the base", "of the model" and "for its FMU"."""
    for said in (" of the joint nearer to the base", " in the joint nearer to the base", " of the model"):
        description = description.replace(said, "")
    return description.removesuffix(", for its FMU")


def _is_table(kind: Any) -> bool:
    return dataclasses.is_dataclass(entry_type(kind))


def _default(default: Any) -> str:
    if default is dataclasses.MISSING:
        return "required"
    if default is None:
        return ""
    if isinstance(default, Derived):
        return default.text.replace("*", "·")
    if isinstance(default, bool):
        return code(str(default).lower())
    if isinstance(default, str):
        return code(f'"{default}"')
    return code(list(default) if isinstance(default, tuple) else f"{default:g}")


def _allowed(kind: Any, rule: Any) -> str:
    kind = without_none(kind)
    if kind is bool:  # the default shows it
        return ""
    item, *rest = get_args(kind) or (kind,)
    text = _readable(allowed(item, rule))
    if get_origin(kind) is not tuple:
        return text
    if rule["per_link"]:
        return f"list, for each link {text}"
    true = "`true`, or " if rule["or_true"] else "a name, or " if rule["or_one"] else ""
    return f"{true}list, each {text}" if ... in rest else f"list of {1 + len(rest)}, each {text}"


def _readable(text: str) -> str:
    if all(f'"{law}"' in text for law in CONTACT_LAWS):
        return "a [law](contact_laws.md#the-laws)"
    text = text.replace("letters, digits and _, not beginning with a digit", "a name")
    text = re.sub(r'"(\w+)"', r'`"\1"`', text.partition(", and no name")[0])
    text = re.sub(r"^a finite number (?=[<>])|^one of | without control characters$", "", text)
    text = text.replace("a finite number [", "[").replace("a finite number", "a number")
    text = text.replace("a whole number", "an integer")
    return text.replace(">=", "≥").replace("<=", "≤").replace(" and ≤", ", ≤")


# ---- FMU variables --------------------------------------------------------------------------------------


def variable_patterns() -> str:
    """Return every kind of variable once, with letters in place of its indices."""
    known = {_of_the_joint(entry.metadata["description"]) for _, entry in scene_keys() if entry.metadata}
    sections = []
    for title, table_of in (("Parameters", PARAMETERS), ("Inputs", INPUTS), ("Outputs", OUTPUTS)):
        alike: dict[str, list[Kind]] = {}
        for kind in (kind for of_one_element in table_of for kind in of_one_element.kinds):
            meaning = _meaning(kind)
            is_key = meaning in known and bool(kind.unit)
            tunable = "; tunable" if kind.tunable == ALWAYS else ""
            alike.setdefault((SCENE_KEY if is_key else meaning) + tunable, []).append(kind)
        lines = (_variables(meaning, kinds) for meaning, kinds in alike.items())
        sections.append(f"### {title}\n\n" + "\n".join(lines))
    return "\n\n".join(sections)


def _variables(meaning: str, kinds: Sequence[Kind]) -> str:
    """Return a line for kinds of one meaning: names, meaning and units; for scene keys the meaning first."""
    names = ", ".join(code(name) for name in dict.fromkeys(kind.pattern for kind in kinds))
    if meaning.startswith(SCENE_KEY):
        return f"- {meaning}: {names}"
    units = ", ".join(unit for unit in dict.fromkeys(kind.unit for kind in kinds) if unit not in ("", "1"))
    return f"- {names}: {meaning}" + (f" [{units}]" if units else "")


SCENE_KEY = "scene key"  # meaning of parameters that the page of the scene file explains
IN_GENERAL = OF_STOPS | {
    "axis": "x and y",
    "n": "i",
    "before": "link i − 1, or the base",
    "parent": "the link before",
    "from_x": "",
    "about": "the origin, of a wall at any angle about its point",
    "losses": "contacts, joint damping and dry friction",
    "wall_numbers": "its [code](#codes)",
    "wall_numbers_if_any": "its [code](#codes)",
    "statuses": "see its [codes](troubleshooting.md#statuses-of-the-solver)",
}
"""Word of a scene or an element → its general form in the table."""
ALIKE = {
    "stops: least and largest angle": ("link[i].joint_min", "link[i].joint_max"),
    "position of the wall": tuple(f"box.{wall}" for wall in WALLS),
    "initial position and velocity of the base; a pinned base has no velocity": (
        *("initial.x", "initial.y", "initial.vx", "initial.vy"),
    ),
    "initial angle and angular velocity of link i, absolute, from +x": (
        *("initial.angle[i]", "initial.angular_velocity[i]"),
    ),
    "position, velocity and acceleration of the base": INPUTS_OF["base_motion"],
    "angle that the spring follows, and angular velocity that the damper follows": (
        *("joint[i].target_angle", "joint[i].target_velocity"),
    ),
    "motion along the inward normal n": (
        *("wall.<wall>.displacement", "wall.<wall>.velocity", "wall.<wall>.acceleration"),
    ),
    "position, velocity and acceleration": tuple(
        f"point[k].{prefix}{axis}" for prefix in ("", "v", "a") for axis in AXES
    ),
    "angle, angular velocity and angular acceleration, absolute, from +x": (
        *("link[i].angle", "link[i].angular_velocity", "link[i].angular_acceleration"),
    ),
    "moment of its stops, positive at joint_min, angle beyond a stop, and impulse since the start": (
        *("joint[i].stop_moment", "joint[i].stop_penetration", "joint[i].stop_impulse"),
    ),
    "how far it has moved along n, and its belt along t = (n_y, -n_x)": (
        *("wall.<wall>.position", "wall.<wall>.belt_position"),
    ),
    "force, along its left normal, and moment of the line on the carriage": (
        *("slider.reaction", "slider.moment"),
    ),
    "angle and angular velocity, relative to the link before": (
        *("joint[i].angle", "joint[i].angular_velocity"),
    ),
    "position along the line, 0 at the start, velocity and acceleration": (
        *("slider.position", "slider.velocity", "slider.acceleration"),
    ),
    "position that the spring of the slider follows, and velocity that the damper follows": (
        *("slider.target_position", "slider.target_velocity"),
    ),
    "dry friction along t = (n_y, -n_x), and its impulse since the start": (
        *("contact[k].<wall>.friction_force", "contact[k].<wall>.friction_impulse"),
    ),
    "time, point, wall ([code](#codes)) and approach speed of the last impact, before the first the start, "
    "-1, 0 and 0; of a stop its joint, and rad/s": (
        *("impact.last_time", "impact.last_point", "impact.last_wall", "impact.last_speed"),
    ),
    "steps, rejected steps, evaluations of the equations, implicit steps": (
        *("solver.steps", "solver.rejected_steps", "solver.rhs_evaluations", "solver.implicit_steps"),
    ),
    "law of walls, and of stops without one of their own: its [number](contact_laws.md#the-laws)": (
        "contact.model",
    ),
}
"""The common meaning of similar variables."""
MEANINGS = {name: meaning for meaning, names in ALIKE.items() for name in names}


def _meaning(kind: Kind) -> str:
    """Return the description without the content of its name and of scene.md, and without long code lists."""
    if kind.pattern in MEANINGS:
        return MEANINGS[kind.pattern]
    choices = choices_of(load_scene("four_link_box"))[METHODS] if kind.choices == METHODS else ()
    listed = ", ".join(f"{number} = {item.name}" for number, item in enumerate(choices, 1))
    heading = "wall at any angle: " if kind.heading == LINE else ""
    return heading + _of_the_joint(kind.text).format_map(IN_GENERAL) + (f": {listed}" if listed else "")


def walls() -> str:
    """Return the numbers of the walls in `impact.last_wall`."""
    box = ", ".join(f"{number} {code(wall)}" for number, wall in enumerate(WALLS, 1))
    return (
        f"0 none, {box}, {len(WALLS) + 1} and on the `[[walls]]` of the scene in their order. In a scene "
        "with stops the two numbers after these are `joint_min` and `joint_max`; the point is then the joint."
    )


def statuses() -> str:
    """Return the status codes of the solver; the messages themselves contain the remedies."""
    return "\n".join(
        f"- {n} {code(STATUS_NAME[n])}: {re.split(':|, as ', text)[0]}" for n, text in STATUS_TEXT.items()
    )


# ---- contact laws, command line -------------------------------------------------------------------------


def contact_laws() -> str:
    """Return the registry of contact laws: the Hunt–Crossley family, the other forces, rigid walls."""
    family = [law for law in CONTACT_LAWS.values() if law.in_family]
    rigid = [law for law in CONTACT_LAWS.values() if law.impulsive]
    others = [law for law in CONTACT_LAWS.values() if not (law.in_family or law.impulsive)]
    return "\n\n".join(
        [
            "### The Hunt–Crossley family",
            table(("id", "law", "λ(e)", "within 5 % for"), map(_law_row, family)),
            "### Other powers of the penetration in the damping",
            table(("id", "law", "f(e)", "within 5 % for"), map(_law_row, others)),
            table(
                ("id", "force, where not cut off at 0", "damping d", "exponent n"),
                ((code(law.id), law.force, law.damping, f"{law.exponent:g}") for law in others),
            ),
            "### Rigid walls",
            table(("id", "law", "f(e)", "within 5 % for"), map(_law_row, rigid)),
        ]
    )


def _law_row(law: ContactLaw) -> Sequence[str]:
    accurate = _accurate(law.accurate_from, law.accurate_to)
    return (
        f"{law.number} {code(law.id)}",
        f"{law.source}. {law.limits}",
        law.formula,
        accurate.replace(" ", "\N{NO-BREAK SPACE}"),
    )


def _accurate(low: float, high: float) -> str:
    if low == high:
        return f"e = {low:g}"
    if low == 0.0:
        return "all e" if high == 1.0 else f"e ≤ {high:g}"
    return f"e ≥ {low:g}"


def stiffnesses() -> str:
    """Return the stiffness of a sphere of some materials on a plane."""
    steel = MATERIALS["steel"]
    rows = (
        (
            name,
            f"{young / 1e9:g}",
            f"{poisson:g}",
            *(
                f"{sphere_plane_stiffness(RADIUS, young, poisson, *plane):.4g}"
                for plane in ((young, poisson), steel)
            ),
        )
        for name, (young, poisson) in MATERIALS.items()
    )
    return table(("sphere of", "E [GPa]", "ν", "K on its own material", "K on steel"), rows)


def planted_faults() -> str:
    """Return the numbers of planted faults that ``validate`` finds, and that FMPy finds."""
    planted = [len(some) + len(WHOLE) for some in FAULTS.values()]
    by_fmpy = [sum(fault.by_fmpy == FOUND for fault in some.values()) for some in FAULTS.values()]
    return (
        f"The tests plant {planted[0]} faults in FMUs of FMI 2.0 and {planted[1]} in FMUs of FMI 3.0. "
        f"`validate` finds all of them; the check of FMPy finds {by_fmpy[0]} and {by_fmpy[1]}."
    )


RESULTS = DOCS.parent / "benchmarks" / "results"


def measured_impacts() -> str:
    """Return the errors of laws, and of a model with compliance, for measured impacts.

    Equal errors share a row.
    """
    record = json.loads((RESULTS / "measured_impacts.json").read_text(encoding="utf-8"))
    facts, found = record["results"]["facts"], record["results"]["odd trials"]
    predicted = {name: one for name, one in found.items() if "median" in one}
    rows: dict[tuple[str, ...], list[str]] = {}
    for name, one in predicted.items():
        cells = tuple(f"{one[key]:.2f}" for key in ("contact.friction", "median", "90 %"))
        rows.setdefault(cells, []).append(_model(name, one))
    head = ("law, with its fitted e", "µ", "median error [m/s]", "90 % below")
    back = sorted(one["moves back"] for one in predicted.values())
    return (
        f"Measured {record['date'][:10]} at commit `{record['commit'][:7]}`. The median speed is "
        f"{facts['speed']:.2f} m/s.\n\n"
        + table(head, [(_few(names), *cells) for cells, names in rows.items()])
        + f"\n\n{facts['moves back']:.0%} of the contact points move back along the wall after the impact, "
        f"{back[0]:.0%} to {back[-1]:.0%} in the simulations. A spring along the wall does not change this, "
        "so contacts here have no compliance along the wall."
    )


NAMED = 3  # largest number of named laws in a row of the table of measured impacts


def _few(names: list[str]) -> str:
    """Return some names, the default law first, and the number of the other names."""
    names = sorted(names, key=lambda name: "`zhang_sharf`" not in name)
    others = f", and {len(names) - NAMED} others" if len(names) > NAMED else ""
    return ", ".join(names[:NAMED]) + others


def _model(name: str, found: dict[str, float]) -> str:
    e, ratio = found["contact.restitution"], found.get("ratio of the stiffnesses")
    return f"{code(name) if ratio is None else f'spring of {ratio:.2g} K along the wall:'} {e:.2f}"


def measured_arm() -> str:
    """Return fitted damping and friction of the measured arm, with and without dry friction, and errors."""
    record = json.loads((RESULTS / "measured_arm.json").read_text(encoding="utf-8"))
    found = record["results"]
    names = max((list(one["parameters"]) for one in found.values()), key=len)
    rows = [
        (code(name), *(_interval(one["parameters"].get(name)) for one in found.values()))
        for name in names
        if "joint" in name
    ]
    for run in ("fitted", "unseen"):
        errors = (f"{one[f'rms, {run}']:.3f}" for one in found.values())
        rows.append((f"error, rms [rad], {run} run", *errors))
    when = f"Measured {record['date'][:10]} at commit `{record['commit'][:7]}`."
    return f"{when}\n\n" + table(("", *found), rows)


def _interval(one: dict[str, float] | None) -> str:
    return "–" if one is None else f"{round(one['value'], 6):.3g} ± {one['±']:.2g}"


TABLES = {
    function.__name__: function
    for function in (
        scene_reference,
        variable_patterns,
        walls,
        statuses,
        contact_laws,
        stiffnesses,
        planted_faults,
        command_line,
        measured_impacts,
        measured_arm,
    )
}


def schema_text() -> str:
    """Return the text of ``scene.schema.json``."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def write() -> None:
    """Write every page, and the schema, anew."""
    for page in sorted(DOCS.rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        page.write_text(filled(text), encoding="utf-8")
    SCHEMA.write_text(schema_text(), encoding="utf-8")


if __name__ == "__main__":
    write()
