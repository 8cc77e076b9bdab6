"""A brick whose four corners may touch, against a brick with two such corners.

``python -m benchmarks bodies``. The brick bounces on its two lower corners. In one scene all four corners are
points of its link; in the other only the two lower ones touch, as the ends of the link, which lies along the
bottom. The motion and its contacts are the same in both. So the ratio of the times is the cost of points
that are not on the line of a link, and of corners that might touch.
"""

from __future__ import annotations

from typing import Any

from benchmarks import common
from benchmarks.peers.ours import Kernel
from chain_impact.scene.scene import Scene, scene_from_dict

BREADTH, HEIGHT, MASS = 0.25, 0.12, 3.5  # [m], [m], [kg]
LOWER, UPPER = ([(0.0, y), (BREADTH, y)] for y in (0.0, HEIGHT))
STOP = 1.0  # [s] stop time; the brick does not turn over in this time
FRICTIONS = (0.0, 0.3)
ROUNDS = 11
CORNERS, ENDS = "four corners, points of the link", "two corners, ends of the link"


def brick(ends: list[int], points: list[tuple[float, float]], friction: float) -> Scene:
    """Return the brick above a floor; ``ends`` and ``points`` of its link may touch."""
    link: dict[str, Any] = {"length": BREADTH, "mass": MASS, "center_of_mass_offset": 0.5 * HEIGHT}
    link["inertia"] = MASS * (BREADTH**2 + HEIGHT**2) / 12.0
    link["points"] = [{"x": x, "y": y} for x, y in points]
    data = {
        "name": "Brick",
        "chain": {"links": [link]},
        "box": {"y_min": 0.0},
        "contact": {
            "model": "flores",
            "stiffness": 1e7,
            "restitution": 0.5,
            "friction": friction,
            "points": ends,
        },
        "initial": {"position": [0.0, 0.1], "velocity": [0.5, 0.0], "angles": [0.05]},
    }
    return scene_from_dict(data, "brick")


def compared(friction: float, rounds: int) -> dict[str, Any]:
    """Return the number of contacts, and the CPU times of both bricks, at a coefficient of friction."""
    scenes = {CORNERS: brick([], LOWER + UPPER, friction), ENDS: brick([0, 1], [], friction)}
    runs = {name: Kernel(scene, STOP) for name, scene in scenes.items()}
    contacts = {name: len(run.outcome().onsets) for name, run in runs.items()}
    assert contacts[CORNERS] == contacts[ENDS], "the bricks move differently"
    timings = common.interleave({name: run.run for name, run in runs.items()}, rounds)
    return {
        "friction": friction,
        "contacts": contacts[ENDS],
        "microseconds a contact": {
            name: common.spread([1e6 * seconds / contacts[name] for seconds in timings[name]])
            for name in runs
        },
        "times as long": common.ratio(timings, CORNERS, ENDS),
    }


def main() -> None:
    """Time the runs of both bricks, and write the results."""
    rounds, started = common.rounds(__doc__, ROUNDS), common.environment()
    results = [compared(friction, rounds) for friction in FRICTIONS]
    for row in results:
        print(row)
    common.save("bodies", started, {"stop [s]": STOP, "rounds": rounds}, results)


if __name__ == "__main__":
    main()
