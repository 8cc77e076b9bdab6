"""The largest values of a run: forces, penetrations, and the moments and rotations at stops of joints."""

from __future__ import annotations

from typing import NamedTuple

from chain_impact.scene.texts.names import DataPath
from chain_impact.variables.impact_units import impact_units, unit_at

JOINT_FORCE = "joint_force"
"""The name of the largest force in any joint [N], of a run and, in ``Result.impacts``, of an impact."""


class PeakOfRun(NamedTuple):
    """The largest value of a quantity over all contacts of a run.

    Attributes:
        path: the path of the largest value in the record.
        name: the name of the largest value in pictures and texts.
        field: the field of ``Result.impacts`` with the largest value of the quantity in each single contact.
        at_stops: True if the contacts are those at stops of joints; False if they are those at walls and at
            stops of a slider.
    """

    path: DataPath
    name: str
    field: str
    at_stops: bool = False

    @property
    def fmi_unit(self) -> str:
        """The unit of the largest value, as an FMU writes it."""
        return impact_units(is_stop=self.at_stops)[self.field]

    @property
    def unit(self) -> str:
        """The unit of the largest value, as a text for readers."""
        return unit_at(self.field, is_stop=self.at_stops)

    @property
    def is_load(self) -> bool:
        """Whether the largest value is a force or a moment, and not a penetration."""
        return self.field == "peak_force"


PEAKS = {
    "peak_force": PeakOfRun(("peaks", "force"), "peak force", "peak_force"),
    "max_penetration": PeakOfRun(("peaks", "penetration"), "largest penetration", "max_penetration"),
    "stop.peak_moment": PeakOfRun(("peaks", "moment"), "peak moment of stops", "peak_force", at_stops=True),
    "stop.max_penetration": PeakOfRun(
        ("peaks", "rotation"), "largest rotation beyond a stop", "max_penetration", at_stops=True
    ),
}
"""Name in sweeps and rankings → peak. Only a scene with stops of joints has the peaks with ``at_stops``."""
