"""Fill the table of docs/validation.md: ``python -m tests.helpers.literature.validation_table``.

validation.py has the problems, the second solutions and the published values.
"""

from __future__ import annotations

import re

from chain_impact.scene.files.models import model_names
from docs.tools import DOCS
from docs.tools.markdown_text import table
from tests.helpers.literature.figures import Figure, Problem
from tests.helpers.literature.validation import PROBLEMS

TOLERANCE = 1e-8  # the default
BLOCK = re.compile(r"(?<=<!-- validation -->\n).*?(?=<!-- end -->)", re.DOTALL)
HEAD = ("problem", "quantity", "published", "second solution", "deviation")
# source of each problem, and parts of the names of the displayed quantities
SHOWN = {
    "double_pendulum_wall": ("Potra et al. 2006; Solfec", "0.6 s"),
    "simple_pendulum": ("IFToMM library, A01", "x at"),
    "bouncing_ball": ("Siconos", "height at 2 s", "time of rest"),
    "elastic_ball": ("SimBenchmark", "RaiSim", "Bullet"),
    "sphere_on_wall": ("Chung & Ooi 2011, tests 2 and 3", "peak force", "prescribed 0.2"),
    "elastic_floor": ("code_aster, SDND108 A", "penetration"),
    "clattering_rod": ("Goyal et al. 1998", "impact 30, of end"),
    "falling_arm": ("Brogliato 2016", "rest of the tip"),
    "steel_bar": ("Stoianovici & Hurmuzlu 1996", "restitution of a bar of 0.4 m"),
    "kneed_leg": ("Hsu Chen 2007", "knee strike: time", "rate of the swinging"),
    "golf_ball": ("Cantarini 2023", "impact 9:"),
    "triple_pendulum": ("Kaheman et al. 2023", "link 3 at 5 s"),
    "kane_pendulum": ("Kane & Levinson 1985", "energy"),
    "siconos_stick": ("Siconos, ImpactingStick", "energy"),
    "glocker_rod": ("Glocker 1995; cardillo", "slide on"),
    "stewart_rod": ("Stewart & Trinkle 1996", "impulse of friction"),
    "rocking_block": ("Housner 1963", "e = 0.1", "extrapolated", "quarter period"),
    "ball_between_walls": ("Siconos, BouncingBallED-TwoContacts", "2 s"),
    "ball_stays": ("Siconos, BouncingBallED-withRestingContact", "time"),
    "ball_on_a_spring": ("Siconos, BouncingBallTS-CompliantContact", "height at 2 s"),
    "sliding_block": ("Potra et al. 2006; Solfec", "5.001 s"),
}


def rows(problem: Problem) -> list[list[str]]:
    """Return the rows of one problem; the first row names the problem and its source."""
    name = problem.model
    table_rows: list[list[str]] = []
    link = f"[{name}](models/{name}.md)" if name in model_names() else f"`{name}`"
    source, *shown = SHOWN[name]
    for figure in problem.figures:
        if not any(part in figure.quantity for part in shown):
            continue
        deviation = f"{abs(figure.ours - figure.independent):.0e}"
        first = "" if table_rows else f"{link}, {source}"
        table_rows.append([first, figure.quantity, published(figure), f"{figure.independent:.7g}", deviation])
    return table_rows


def published(figure: Figure) -> str:
    """Return the published or measured value, in bold if inaccurate; a word or a dash if there is none."""
    if figure.published is None:
        return "equation" if figure.equation else "–"
    text = f"{float(figure.published):.9g}"
    if figure.measured:
        return f"{text} (measured)"
    return f"**{text}**" if figure.inaccurate else text


def main() -> None:
    """Run all problems, and fill the table."""
    lines = [row for function in PROBLEMS.values() for row in rows(function(TOLERANCE))]
    page = DOCS / "validation.md"
    text = page.read_text(encoding="utf-8")
    page.write_text(BLOCK.sub(lambda _: f"\n{table(HEAD, lines)}\n\n", text), encoding="utf-8")


if __name__ == "__main__":
    main()
