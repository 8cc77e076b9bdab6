"""The table of docs/validation.md: ``python docs/validation_table.py`` computes it and puts it there.

The problems, the second solutions and what was published are in tests/validation.py, which tests check, too.
"""

from __future__ import annotations

import re

from generate import DOCS, table  # adds the folder of the tests to Python's path

from chain_impact.scene.scene import model_names
from tests.validation import PROBLEMS, Figure, Problem

DEFAULT, TIGHT = 1e-8, 1e-12  # tolerances
BLOCK = re.compile(r"(?<=<!-- validation -->\n).*?(?=<!-- end -->)", re.DOTALL)
HEAD = ("problem", "quantity", "published", "second solution", "ours", "deviation", "at 10⁻¹²")
SOURCES = {
    "double_pendulum_wall": "Potra et al. 2006; Solfec",
    "simple_pendulum": "IFToMM library, A01",
    "bouncing_ball": "Siconos",
    "elastic_ball": "SimBenchmark",
    "sphere_on_wall": "Chung & Ooi 2011, tests 2 and 3",
    "elastic_floor": "code_aster, SDND108 A",
    "clattering_rod": "Goyal et al. 1998",
    "falling_arm": "Brogliato 2016",
    "steel_bar": "Stoianovici & Hurmuzlu 1996; Euler–Bernoulli",
    "kneed_leg": "Hsu Chen 2007",
    "golf_ball": "Cantarini 2023, laboratory course",
    "triple_pendulum": "Kaheman et al. 2023",
    "kane_pendulum": "Kane & Levinson 1985",
    "siconos_stick": "Siconos, ImpactingStick",
    "glocker_rod": "Glocker 1995; cardillo",
    "stewart_rod": "Stewart & Trinkle 1996",
    "rocking_block": "Housner 1963",
    "ball_between_walls": "Siconos, BouncingBallED-TwoContacts",
    "ball_stays": "Siconos, BouncingBallED-withRestingContact",
    "ball_on_a_spring": "Siconos, BouncingBallTS-CompliantContact",
    "sliding_block": "Potra et al. 2006; Solfec",
}
# quantities that the page leaves out
LEFT_OUT = (
    "impact 10",
    "impact 20",
    "y at 10 s [m]",
    "height at 4 s",
    "prescribed 0.4",
    "prescribed 0.6",
    "second contact",
    "speed at contact",
    "at 2 s [rad]",
    "height at 3 s",
    "at 8.001 s",
    "at 6.151 s",
)


def rows(problem: Problem, tight: Problem) -> list[list[str]]:
    """The rows of one problem, run at both tolerances; the first one names it and its source."""
    name, found = problem.model, []
    link = f"[{name}](models/{name}.md)" if name in model_names() else f"`{name}`"
    for figure, exact in zip(problem.figures, tight.figures, strict=True):
        if any(text in figure.quantity for text in LEFT_OUT):
            continue
        solutions = (f"{value:.7g}" for value in (figure.independent, figure.ours))
        deviations = (f"{abs(one.ours - one.independent):.0e}" for one in (figure, exact))
        first = "" if found else f"{link}, {SOURCES[name]}"
        found.append([first, figure.quantity, published(figure), *solutions, *deviations])
    return found


def published(figure: Figure) -> str:
    """What the source says or measured; bold where it is inaccurate."""
    if figure.published is None:
        return "equation" if figure.equation else "–"
    text = f"{float(figure.published):.9g}"
    if figure.measured:
        return f"{text} (measured)"
    return f"**{text}**" if figure.inaccurate else text


def main() -> None:
    """Run all problems, and fill the table."""
    lines = [row for function in PROBLEMS.values() for row in rows(function(DEFAULT), function(TIGHT))]
    page = DOCS / "validation.md"
    text = page.read_text(encoding="utf-8")
    page.write_text(BLOCK.sub(lambda _: f"\n{table(HEAD, lines)}\n\n", text), encoding="utf-8")


if __name__ == "__main__":
    main()
