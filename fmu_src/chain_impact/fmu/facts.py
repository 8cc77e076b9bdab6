"""Facts on a scene that an FMU contains beside its variables.

They are the names of points, and the rules by which parameters follow from others.
"""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import NamedTuple

from chain_impact.variables.prepared import PreparedScene

FACTS_FILE = "resources/chain_impact_scene.json"


class Facts(NamedTuple):
    """The facts on the scene of an FMU.

    Attributes:
        point_names: number of a point → its name, for the points that have one.
        rules: name of a parameter → the rule by which its value follows from others unless it is set.
    """

    point_names: dict[int, str]
    rules: dict[str, str]


def facts_file(prepared: PreparedScene) -> dict[str, bytes]:
    """Return the file with the facts on a scene, by its path in the FMU."""
    rules = {variable.name: variable.rule.text for variable in prepared.parameters if variable.rule}
    facts = Facts(prepared.scene.point_names, rules)
    return {FACTS_FILE: json.dumps(facts._asdict(), ensure_ascii=False).encode()}


def read_facts(fmu: Path) -> Facts:
    """Return the facts on the scene of an FMU; there are none if the FMU does not have the file."""
    with zipfile.ZipFile(fmu) as files:
        if FACTS_FILE not in files.namelist():
            return Facts({}, {})
        facts = Facts(**json.loads(files.read(FACTS_FILE)))
    return facts._replace(point_names={int(number): name for number, name in facts.point_names.items()})
