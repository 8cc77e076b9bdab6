"""Problems from the literature, recomputed: ``python benchmarks/validation.py`` fills docs/validation.md.

The problems, the second solutions and what was published are in tests/validation.py, which tests check, too.
Nothing is timed: the cost of a run is its steps and evaluations.
"""

from __future__ import annotations

import common  # isort: skip

import re

from table import fill, run, table

from chain_impact.scene.scene import model_names
from tests.validation import PROBLEMS, Figure, Problem

DEFAULT, TIGHT = 1e-8, 1e-12  # tolerances
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
}


SHOWN = (
    "problem",
    "quantity",
    "published",
    "second solution",
    "ours",
    "deviation",
    "at 10⁻¹²",
)  # columns of the page; the file has more

# rows that only the file has
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
)


def shown(row: dict[str, str]) -> list[str]:
    """A row of the page's table, which has the source beside the problem."""
    problem = f"{row['problem']}, {row['source']}" if row["problem"] else ""
    solutions = (f"{float(row[name]):.7g}" for name in ("second solution", "ours"))
    deviations = (row[name] for name in ("deviation", "deviation at 10⁻¹²"))
    quoted = re.sub(r"-?\d[\d.e-]*", lambda number: f"{float(number[0]):.9g}", row["published"])
    return [problem, row["quantity"], quoted, *solutions, *deviations]


def rows(problem: Problem, tight: Problem) -> list[dict[str, str]]:
    """The rows of one problem, run at both tolerances."""
    name = problem.model
    link = f"[{name}](models/{name}.md)" if name in model_names() else f"`{name}`"
    cost = f"{problem.steps} / {problem.evaluations}"
    return [
        {
            "problem": "" if row else link,
            "source": "" if row else SOURCES[name],
            "quantity": figure.quantity,
            "published": published(figure),
            "second solution": f"{figure.independent:.12g}",
            "ours": f"{figure.ours:.12g}",
            "deviation": deviation(figure),
            "deviation at 10⁻¹²": deviation(exact),
            "steps / evaluations": "" if row else cost,
        }
        for row, (figure, exact) in enumerate(zip(problem.figures, tight.figures, strict=True))
    ]


def published(figure: Figure) -> str:
    """What the source says or measured; bold where it is inaccurate."""
    if figure.published is None:
        return "equation" if figure.equation else "–"
    text = f"{float(figure.published):.12g}"
    if figure.measured:
        return f"{text} (measured)"
    return f"**{text}**" if figure.inaccurate else text


def deviation(figure: Figure) -> str:
    """Ours from the second solution."""
    return f"{abs(figure.ours - figure.independent):.0e}"


def main() -> None:
    """Run all problems, keep the figures, and fill the table."""
    started = common.environment(("scipy",))
    results = [row for function in PROBLEMS.values() for row in rows(function(DEFAULT), function(TIGHT))]
    common.save("validation", started, {"tolerances": [DEFAULT, TIGHT]}, results)
    lines = [shown(row) for row in results if not any(text in row["quantity"] for text in LEFT_OUT)]
    fill("validation.md", {"validation": lambda: run("validation") + "\n\n" + table(SHOWN, lines)})


if __name__ == "__main__":
    main()
