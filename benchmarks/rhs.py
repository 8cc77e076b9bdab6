"""Cost of one right-hand side: ``python benchmarks/rhs.py [--quick]``.

In flight, against the number of links: the kernel's ``state_rate``, compiled just as the shipped kernel is
(rhs_loop.py); the same recursion over plain arrays (plain_chain.py), compiled by numba for the same
processor; and the textbook assembly of M(q) in NumPy with ``np.linalg.solve`` (tests/textbook.py).
With dry friction: a chain lies straight on a floor with its tip. The kernel's right-hand side is timed
without friction, while the tip slides, and while it sticks, each on its record as it is in a step of its run.
"""

from __future__ import annotations

import common  # isort: skip

import numpy as np
from looks import BLUE, INK, OURS, curve, headline, names_at_ends, strong
from numba import njit
from plain_chain import flight_rate, plain_chain, start
from rhs_loop import kernel_rates

from chain_impact.scene.scene import Scene, scene_from_dict
from chain_impact.simulation.instance import Instance
from tests.textbook import Textbook

SIZES = (1, 2, 4, 10, 30, 100, 300, 1000)
CALLS = {1: 20000, 30: 4000, 300: 400}  # right-hand sides in one compiled loop, from this size on
ROUNDS = 15
LYING_SIZES = (4, 10)
COEFFICIENTS = {"no friction": 0.0, "slides": 0.01, "sticks": 5.0}
TIME = 0.1  # s, at which the tip touches the floor with each of them


# fmt: off
@njit(error_model="numpy")
def many_plain(  # noqa: PLR0917
    gravity, length, mass, ratio, joint_inertia, lx, ly,
    load_x, load_y, moment, gain_x, gain_y, bias, y, out, calls
):
    """Right-hand sides in a row; each depends on the last one, as in rhs_loop.py."""
    for _ in range(calls):
        flight_rate(
            gravity, length, mass, ratio, joint_inertia, lx, ly,
            load_x, load_y, moment, gain_x, gain_y, bias, y, out
        )  # fmt: skip
        for j in range(len(y)):
            y[j] += 1e-30 * out[j]


# fmt: on
def chain(links: int) -> Scene:
    """A chain in flight, folded and turning."""
    wave = np.arange(links)
    return scene_from_dict(
        {
            "name": "Flight",
            "gravity": [0.0, -9.81],
            "chain": {"base": "free", "links": [{"length": 0.5, "mass": 1.0}] * links},
            "box": {},
            "contact": {"points": []},
            "initial": {
                "position": [0.6, 1.4],
                "angles": list(0.8 * np.sin(1.0 + 1.7 * wave)),
                "angular_velocities": list(1.5 * np.cos(2.3 * wave)),
            },
        },
        "chain",
    )


def lying(links: int, friction: float) -> Scene:
    """A straight chain that is level, and whose tip may touch the floor."""
    given = {"friction": friction} if friction else {}
    return scene_from_dict(
        {
            "name": "Lying",
            "chain": {"links": [{"length": 0.5, "mass": 1.0}] * links},
            "box": {"y_min": 0.0},
            "contact": {"stiffness": 1e5, "restitution": 0.5, "points": [links]} | given,
            "initial": {"position": [0.0, 0.0], "angles": [0.0] * links},
            "solver": {"method": "explicit"},
            "simulation": {"stop_time": 2.0 * TIME, "step_size": TIME},
        },
        "lying",
    )


def in_flight(links: int, rounds: int) -> dict:
    """Time the three for a number of links, after checking that they agree."""
    scene = chain(links)
    calls = next(count for least, count in reversed(CALLS.items()) if links >= least)
    instance, y = Instance(scene), start(scene)
    many_kernel, address = kernel_rates(links), instance._address
    many_kernel(address, 1)
    ours = instance.record["work"]["stage"][1]
    arrays, plain = plain_chain(scene)[:5] + tuple(np.zeros((8, links + 1))), np.zeros(len(y))
    many_plain(*arrays, y.copy(), plain, 1)
    textbook = Textbook(scene)
    expected = textbook.rate(y)
    scale = np.abs(expected).max()
    disagreement = max(np.abs(ours[: len(y)] - expected).max(), np.abs(plain - expected).max()) / scale
    assert disagreement < 1e-9, disagreement
    contenders = {
        "ours": (lambda: many_kernel(address, calls), calls),
        "plain arrays": (lambda: many_plain(*arrays, y, plain, calls), calls),
        "NumPy": (lambda: textbook.rate(y), 1),
    }
    return {"links": links, "disagreement": common.rounded(disagreement, 2), **compared(contenders, rounds)}


def in_contact(links: int, rounds: int) -> dict:
    """Time the kernel's with its tip on the floor: no friction, sliding, sticking."""
    contenders, calls = {}, CALLS[1]
    for name, friction in COEFFICIENTS.items():
        instance = Instance(lying(links, friction))
        instance.trajectory(np.array([TIME]), np.zeros(1, instance.record.dtype["output"]))
        mode = instance.record["friction"]
        assert instance.record["touch"]["active_count"] == 1
        assert (mode["count"], mode["stuck_count"]) == (name != "no friction", name == "sticks")
        contenders[name] = (lambda one=instance: kernel_rates(links)(one._address, calls)), calls
    return {"links": links, **compared(contenders, rounds)}


def compared(contenders: dict, rounds: int) -> dict:
    """Nanoseconds of one right-hand side of each, and the ratios to the first.

    Args:
        contenders: name → a call, and how many right-hand sides it makes.
        rounds: how often each is timed.
    """
    timings = common.interleave({name: call for name, (call, _) in contenders.items()}, rounds)
    each = {name: [value / contenders[name][1] for value in row] for name, row in timings.items()}
    nanoseconds = {name: common.median([1e9 * value for value in row]) for name, row in each.items()}
    first, *others = each
    found = {"nanoseconds": nanoseconds}
    found |= {f"{name} / {first}": common.ratio(each, name, first) for name in others}
    print(found, flush=True)
    return found


SIZE = (10.5, 4.2)  # inches, of the chart


def draw(page, record) -> None:
    """Cost on the left, cost for each link on the right."""
    rows = record["results"]["flight"]
    links = np.array([row["links"] for row in rows])
    looks = {
        "NumPy": (INK, "s", "NumPy: assemble\nM(q), solve"),
        "plain arrays": (BLUE, "^", "same recursion,\nplain arrays"),
        "ours": (OURS, "o", "chain-impact"),
    }
    whole, each = page.subplots(1, 2)
    ends = {whole: [], each: []}
    for name, (colour, marker, text) in looks.items():
        cost = np.array([row["nanoseconds"][name] for row in rows])
        drawn = strong(name == "ours", colour, marker)
        ends[whole].append(curve(whole, list(zip(links, cost, strict=True)), drawn, text))
        if name != "NumPy":
            each.semilogx(links, cost / links, **drawn)
            last = cost[-1] / links[-1]
            ends[each].append((links[-1], last, f"{text}: {last:.0f} ns", colour))
    whole.set(xlabel="links N", ylabel="one right-hand side in flight [ns]")
    each.set(xlabel="links N", ylabel="for each link [ns]", ylim=(0, 50))
    least = min(row["NumPy / ours"]["median"] for row in rows)
    headline(
        page,
        f"A right-hand side costs {cost[-1] / links[-1]:.0f} ns for each link of a long chain, "
        f"with NumPy at least {least:.0f} times as much",
        f"median of {record['settings']['rounds']} rounds in which all take turns",
    )
    names_at_ends(page, ends)


def main() -> None:
    """Measure and draw."""
    rounds = common.rounds(__doc__, ROUNDS)
    started = common.environment()
    results = {
        "flight": [in_flight(links, rounds) for links in SIZES],
        "friction": [in_contact(links, rounds) for links in LYING_SIZES],
    }
    settings = {"rounds": rounds, "calls in a loop": CALLS, "compiled for": common.PORTABLE_CPU}
    common.save("rhs", started, settings, results)
    common.picture("rhs", draw, SIZE)


if __name__ == "__main__":
    main()
