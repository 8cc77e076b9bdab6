"""Fill the tables of the docs from the code: ``python -m docs.tools.generate``.

The script replaces the text between ``<!-- generated: name -->`` and ``<!-- end -->`` in a page by the result
of the function ``name`` in TABLES, and writes the number of laws into the texts that state it. It also writes
the JSON schema of scene files, ``scene.schema.json``.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence

from chain_impact import sphere_plane_stiffness
from chain_impact.kernel.forces.contact_law import ContactLaw
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from docs.tools import DOCS
from docs.tools.command_help import command_line
from docs.tools.markdown_text import code, table
from docs.tools.scene_page import scene_reference
from docs.tools.scene_schema import schema
from docs.tools.variables_page import statuses, variable_patterns, walls

SCHEMA = DOCS / "scene.schema.json"
WITH_LAW_COUNT = [DOCS.parent / name for name in ("README.md", "CITATION.cff")]
BLOCK = re.compile(r"(?<=^<!-- generated: )(\w+)( -->\n).*?(?=^<!-- end -->$)", re.MULTILINE | re.DOTALL)
RADIUS = 0.02  # [m] radius of the spheres in the table of stiffness
LAW_COUNT = re.compile(r"\b(?<!first )\d+(?= (?:contact )?laws\b(?!, see))")
"""Matches the number of all contact laws in a text, but not a number of some laws that a command prints."""
METALS = {
    "mild steel": (207e9, 0.3, 7850.0, 300e6),
    "copper, annealed": (120e9, 0.34, 8960.0, 70e6),
    "lead": (16e9, 0.44, 11340.0, 12e6),
}
"""Metal → Young's modulus [Pa], Poisson's ratio, density [kg/m³] and yield stress [Pa], typical values."""
SPEEDS = (1.0, 5.0)  # [m/s] impact speeds of the restitutions
# typical Young's modulus [Pa] and Poisson's ratio of each material
MATERIALS = {
    "steel": (207e9, 0.3),
    "aluminium": (70e9, 0.33),
    "PMMA": (3.0e9, 0.38),
    "nylon": (2.7e9, 0.39),
    "rubber": (5e6, 0.49),
}


def filled(page: str) -> str:
    """Return the text of a page with tables and the number of contact laws from the code."""
    text = BLOCK.sub(lambda match: f"{match[1]}{match[2]}\n{TABLES[match[1]]()}\n\n", page)
    return LAW_COUNT.sub(str(len(CONTACT_LAWS)), text)


# ---- contact laws, command line -------------------------------------------------------------------------


def contact_laws() -> str:
    """Return tables of all contact laws: the Hunt–Crossley family, the other forces, rigid walls."""
    family = [law for law in CONTACT_LAWS.values() if law.in_family]
    rigid = [law for law in CONTACT_LAWS.values() if law.rigid]
    other_laws = [law for law in CONTACT_LAWS.values() if not (law.in_family or law.rigid)]
    return "\n\n".join(
        [
            "### The Hunt–Crossley family",
            table(("id", "law", "λ(e)", "within 5 % for"), map(_law_row, family)),
            "### Other powers of the penetration in the damping",
            table(("id", "law", "f(e)", "within 5 % for"), map(_law_row, other_laws)),
            table(
                ("id", "force, where not cut off at 0", "damping d", "exponent n"),
                ((code(law.id), law.force, law.damping, f"{law.exponent:g}") for law in other_laws),
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
    """Return a table of the stiffness of spheres of several materials on planes."""
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


def restitutions() -> str:
    """Return a table of the restitution of a yielding sphere on a plane of the same metal."""
    rows = []
    for name, (young, poisson, density, stress) in METALS.items():
        combined = young / (2.0 * (1.0 - poisson**2))
        # the kinetic energy of the sphere, relative to yield stress Y times R³: its mass m is (4/3) π ρ R³,
        # so ½ m v² / (Y R³) = (2/3) π ρ v² / Y; the restitution is from Johnson 1985, chapter 11
        values = (
            3.8 * math.sqrt(stress / combined) * (2.0 / 3.0 * math.pi * density * speed**2 / stress) ** -0.125
            for speed in SPEEDS
        )
        rows.append((name, f"{stress / 1e6:g}", *(f"{e:.2f}" for e in values)))
    return table(("metal", "Y [MPa]", *(f"e at {speed:g} m/s" for speed in SPEEDS)), rows)


RESULTS = DOCS.parent / "benchmarks" / "results"


def measured_impacts() -> str:
    """Return a table of the errors of laws, and of a model with compliance, for measured impacts.

    Laws with equal errors share a row.
    """
    record = json.loads((RESULTS / "measured_impacts.json").read_text(encoding="utf-8"))
    facts, trials = record["results"]["facts"], record["results"]["odd trials"]
    predicted = {name: result for name, result in trials.items() if "median" in result}
    rows: dict[tuple[str, ...], list[str]] = {}
    for name, result in predicted.items():
        cells = tuple(f"{result[key]:.2f}" for key in ("contact.friction", "median", "90 %"))
        rows.setdefault(cells, []).append(_model(name, result))
    head = ("law, with its fitted e", "µ", "median error [m/s]", "90 % below")
    back = sorted(result["moves back"] for result in predicted.values())
    return (
        f"Measured {record['date'][:10]} at commit `{record['commit'][:7]}`. The median speed is "
        f"{facts['speed']:.2f} m/s.\n\n"
        + table(head, [(_few(names), *cells) for cells, names in rows.items()])
        + f"\n\n{facts['moves back']:.0%} of the contact points move back along the wall after the impact, "
        f"{back[0]:.0%} to {back[-1]:.0%} in the simulations. A spring along the wall does not change this, "
        "so contacts here have no compliance along the wall."
    )


MOST_NAMED_LAWS = 3  # largest number of named laws in a row of the table of measured impacts


def _few(names: list[str]) -> str:
    """Return some names, the default law first, and the number of the other names."""
    names = sorted(names, key=lambda name: "`zhang_sharf`" not in name)
    rest_text = f", and {len(names) - MOST_NAMED_LAWS} others" if len(names) > MOST_NAMED_LAWS else ""
    return ", ".join(names[:MOST_NAMED_LAWS]) + rest_text


def _model(name: str, result: dict[str, float]) -> str:
    e, ratio = result["contact.restitution"], result.get("ratio of the stiffnesses")
    return f"{code(name) if ratio is None else f'spring of {ratio:.2g} K along the wall:'} {e:.2f}"


def measured_arm() -> str:
    """Return a table of the damping and friction fitted to a measured arm, and of the errors.

    The table has a column for the model with dry friction and one for the model without it.
    """
    record = json.loads((RESULTS / "measured_arm.json").read_text(encoding="utf-8"))
    results = record["results"]
    names = max((list(result["parameters"]) for result in results.values()), key=len)
    rows = [
        (code(name), *(_interval(result["parameters"].get(name)) for result in results.values()))
        for name in names
        if "joint" in name
    ]
    for run in ("fitted", "unseen"):
        errors = (f"{result[f'rms, {run}']:.3f}" for result in results.values())
        rows.append((f"error, rms [rad], {run} run", *errors))
    when = f"Measured {record['date'][:10]} at commit `{record['commit'][:7]}`."
    return f"{when}\n\n" + table(("", *results), rows)


def _interval(estimate: dict[str, float] | None) -> str:
    return "–" if estimate is None else f"{round(estimate['value'], 6):.3g} ± {estimate['±']:.2g}"


TABLES = {
    function.__name__: function
    for function in (
        scene_reference,
        variable_patterns,
        walls,
        statuses,
        contact_laws,
        stiffnesses,
        restitutions,
        command_line,
        measured_impacts,
        measured_arm,
    )
}


def schema_text() -> str:
    """Return the text of ``scene.schema.json``."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def write() -> None:
    """Write every page and the schema."""
    for page in (*sorted(DOCS.rglob("*.md")), *WITH_LAW_COUNT):
        text = page.read_text(encoding="utf-8")
        page.write_text(filled(text), encoding="utf-8")
    SCHEMA.write_text(schema_text(), encoding="utf-8")


if __name__ == "__main__":
    write()
