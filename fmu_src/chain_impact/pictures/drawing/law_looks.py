"""The colour and dashes of each contact law, the same in all pictures."""

from __future__ import annotations

from typing import Any

from chain_impact.pictures.drawing.colours import BLACK, BLUE, BROWN, GREEN, INK, PURPLE, VERMILLION
from chain_impact.pictures.drawing.dark_ground import UMBER

LAW_LOOKS: dict[str, dict[str, Any]] = {
    "zhang_sharf": {"color": BLACK},
    "hertz": {"color": BLUE},
    "hunt_crossley": {"color": VERMILLION},
    "lankarani_nikravesh": {"color": GREEN},
    "flores": {"color": PURPLE},
    "kelvin_voigt": {"color": "#909954"},
    "gharib_hurmuzlu": {"color": UMBER},
    "carvalho_martins": {"color": "#590043", "linestyle": "-."},
    "jankowski": {"color": "#e60000", "linestyle": "-."},
    "newton_impact": {"color": INK, "linestyle": ":"},
    "herbert_mcwhannell": {"color": "#802000", "linestyle": "--"},
    "lee_wang": {"color": "#164959", "linestyle": "--"},
    "gonthier": {"color": "#808020", "linestyle": "--"},
    "ye": {"color": "#8729a6", "linestyle": "--"},
    "tsuji": {"color": "#3900e6", "linestyle": "--"},
    "zhiying_qishao": {"color": "#2d5938", "linestyle": "-."},
    "hu_guo": {"color": "#cc33cc", "linestyle": "-."},
    "kuwabara_kono": {"color": "#00a653", "linestyle": "-."},
}
"""Law → properties of its lines, with matplotlib's names. No two laws have the same colour. Lines are solid
for the laws that are used most, dotted for newton_impact, and dashed or dash-dotted for all other laws.
Colour-blind readers can distinguish the colours of all laws with the same dashes."""
USER_LAW_LOOK: dict[str, Any] = {"color": BROWN}


def law_look(law: str) -> dict[str, Any]:
    """Return the colour and dashes of a law's lines; a law from a user's file has those of USER_LAW_LOOK."""
    return LAW_LOOKS.get(law, USER_LAW_LOOK)
