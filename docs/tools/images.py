"""Draw the images that no command of a page draws, with Chromium: ``python -m docs.tools.images``."""

from __future__ import annotations

import shlex
import subprocess
import sys

from docs.tools import DOCS

PROGRAMS = (
    "-m chain_impact.cli animate four_link_box --set simulation.stop_time=1.25 --impact-time 0.4 "
    "--size 800x450 -o docs/images/four_link_box.gif",
    "-m chain_impact.cli compare four_link_box --plot docs/images/compare.png",
    "-m chain_impact.cli simulate four_link_box --stop-time 1.1 --sensitivity "
    'contact.restitution,contact.stiffness --sensitivity "link[2].mass" --plot docs/images/sensitivities.png',
    "-m chain_impact.cli sweep four_link_box --set simulation.stop_time=0.6 "
    "--vary contact.restitution=0.05:0.95:46 --vary contact.stiffness=1e6:1e9:31:log -o build/map.csv "
    "--plot docs/images/sweep.png",
    "-m docs.tools.screenshot",
    "-m tests.helpers.literature.beside_measurements",
    "-m docs.tools.sensitivity_chart",
    "-m docs.tools.paper_chart",
    "-m docs.tools.charts",
    "-m benchmarks tables --charts",
)
"""The arguments of Python that draw the images."""


def main() -> None:
    """Run all programs, one after the other."""
    (DOCS.parent / "build").mkdir(exist_ok=True)
    for program in PROGRAMS:
        print(program, flush=True)
        subprocess.run([sys.executable, *shlex.split(program)], cwd=DOCS.parent, check=True)


if __name__ == "__main__":
    main()
