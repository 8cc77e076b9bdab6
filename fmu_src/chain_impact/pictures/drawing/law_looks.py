"""The colour and dashes of each contact law, the same in all pictures."""

from __future__ import annotations

from typing import Any

from chain_impact.pictures.drawing.dark_ground import OCHRE, PLUM, UMBER
from chain_impact.pictures.drawing.style import BLACK, BLUE, BROWN, GREEN, INK, PURPLE, VERMILLION, VIOLET

LAW_LOOKS: dict[str, dict[str, Any]] = {
    "zhang_sharf": {"color": BLACK},
    "hertz": {"color": BLUE},
    "hunt_crossley": {"color": VERMILLION},
    "lankarani_nikravesh": {"color": GREEN},
    "flores": {"color": PURPLE},
    "kelvin_voigt": {"color": OCHRE},
    "gharib_hurmuzlu": {"color": UMBER},
    "carvalho_martins": {"color": PLUM},
    "jankowski": {"color": VIOLET, "linestyle": "-."},
    "newton_impact": {"color": INK, "linestyle": ":"},
    "herbert_mcwhannell": {"color": VERMILLION, "linestyle": "--"},
    "lee_wang": {"color": BLUE, "linestyle": "--"},
    "gonthier": {"color": GREEN, "linestyle": "--"},
    "ye": {"color": PURPLE, "linestyle": "--"},
    "tsuji": {"color": OCHRE, "linestyle": "--"},
    "zhiying_qishao": {"color": UMBER, "linestyle": "--"},
    "hu_guo": {"color": PLUM, "linestyle": "--"},
    "kuwabara_kono": {"color": VIOLET, "linestyle": "--"},
}
"""Law → properties of its lines, with matplotlib's names. Lines are solid for the
laws that are used most, dotted for newton_impact, dashed for all other laws; but dash-dotted
for jankowski, as VIOLET looks like BLUE, the colour of hertz, to colour-blind readers."""
USER_LAW_LOOK: dict[str, Any] = {"color": BROWN}


def law_look(law: str) -> dict[str, Any]:
    """Return the colour and dashes of a law's lines; a law from a user's file has those of USER_LAW_LOOK."""
    return LAW_LOOKS.get(law, USER_LAW_LOOK)
