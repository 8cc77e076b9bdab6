"""A random search over scenes: no run hangs, gains or loses energy, or lets a point through a wall.

``scene(seed)`` of tests/helpers/campaigns/random_scenes.py makes the scene of a failure again,
``verdict(scene(seed), seed)`` of tests/helpers/campaigns/search.py judges it again, and ``python -m
tests.helpers.campaigns.search`` searches further. Runs do not depend on observations, and a folded chain
loses no energy beyond Newton's law.
"""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import with_values
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.folds import faults
from tests.helpers.campaigns.oracle import account, judge
from tests.helpers.campaigns.random_scenes import (
    DRIVEN,
    EQUAL,
    FOLDED,
    LENGTH,
    LONG,
    RUBBED,
    SIGNALLED,
    SLANTED,
    SPRUNG,
    STOPPED,
    TAUT,
    UNEVEN,
    fold,
    scene,
    started,
)
from tests.helpers.campaigns.search import verdict, verdicts
from tests.helpers.scenes.problems import GRAVITY, build, default_scene

BLOCK = 50  # seeds
FIRST = [*range(0, 6 * BLOCK, BLOCK), SLANTED, SPRUNG, FOLDED, TAUT, STOPPED, UNEVEN]
FIRST += [RUBBED, DRIVEN, SIGNALLED, EQUAL]
BLOCKS = [range(first, first + BLOCK) for first in FIRST] + [range(LONG, LONG + BLOCK // 2)]


def broken(run_verdict):
    """Return the findings of a run, but accept a run that ends with a status or takes longer than 2 s."""
    return [finding for finding in run_verdict.findings if finding.kind not in {"stopped", "slow"}]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("seeds", BLOCKS, ids=lambda seeds: f"{seeds[0]}-{seeds[-1]}")
def test_random_scenes_keep_the_laws_of_physics(seeds):
    broken_verdicts = [each for each in verdicts(seeds) if broken(each)]
    assert not broken_verdicts, f"{len(broken_verdicts)} of {len(seeds)} scenes:\n" + "\n".join(
        map(str, broken_verdicts)
    )


# --- scenes that had findings ------------------------------------------------------------------------------

# Causes: ends of contacts with a wrong interpolant of a stiff step; points in toggle positions, or wedged
# under rigid walls; bounces too low for a difference from rest; first steps with stiff joints; ends at loose
# tolerances; outputs in an unstable explicit step; a step toward the end of a contact whose penetration is
# round-off; forces in joints that rise and fall several times in an implicit step.
# fmt: off
MENDED = [
    77, 179, 190, 279, 394, 475, 630, 826, 1509, 1791, 2455, 2655, 2716, 3137, 3165, 3791, 3822, 3861,
    3873, 3900, 3972, 4633, 4647, 4724, 5015, 5044, 5646, 6014, 6508, 6909, 7258, 8026, 9115, 9864, 9955,
    10089, 10329, 10688, 10860, 11059, 11589, 11731, 12517, 13018, 13804, 14480, 15412, 15578, 15729,
    15872, 16529, 17279, 18112, 18276, 18576, 19186, 19544, 19615, TAUT + 1530,
    RUBBED + 1741, RUBBED + 3347, RUBBED + 3671, DRIVEN + 1536, DRIVEN + 2972,
]
# fmt: on


@pytest.mark.full("more cases", but=12)
@pytest.mark.parametrize("seed", MENDED)
def test_a_scene_that_had_findings_has_none(seed):
    result = verdict(scene(seed), seed, cpu=20.0)
    assert {finding.kind for finding in result.findings} <= {"slow"}


@pytest.mark.parametrize("seed", [430, 13415, SLANTED + 458, SLANTED + 1952])
def test_no_output_shows_a_point_behind_a_wall_that_the_search_has_passed(seed):
    """At a loose tolerance the error of the dense output may exceed the distance of a point from a wall."""
    assert not judge(account(scene(seed), seed, rows=1000))


# --- the oracle must be able to find something -----------------------------------------------------------


def test_a_run_that_takes_too_long_is_ended_and_found():
    endless = with_values(default_scene(model="hertz"), {("simulation", "stop_time"): 1e4})
    result = verdict(endless, 7, cpu=0.1)
    assert result.kinds == ["slow"]
    assert result.status is None
    assert "ended at" in str(result)
    assert "scene(7)" in str(result)
    # the next run is judged as usual
    assert not verdict(default_scene(), 7).findings


@pytest.mark.parametrize(
    ("field", "factor", "kinds"),
    [
        ("x", 1.0 + 1e-8, {"newton"}),
        ("impulse_y", 1.0 + 1e-7, {"momentum"}),
        ("peak", 0.99, {"peak"}),
    ],
)
def test_a_wrong_load_is_found(field, factor, kinds):
    run = account(scene(51), 51)
    assert not judge(run)
    run.outputs["transmitted"][field] *= factor
    assert {finding.kind for finding in judge(run)} >= kinds


# --- a run does not depend on when it is observed ----------------------------------------------------------

EACH = 20  # scenes of each kind
SEEDS = {
    name: range(first, first + EACH)
    for name, first in {
        "plain": 0,
        "slanted": SLANTED,
        "springs": SPRUNG,
        "folds": FOLDED,
        "stiff springs": TAUT,
        "stops": STOPPED,
        "rigid walls": UNEVEN,
        "friction": RUBBED,
        "drives": DRIVEN,
    }.items()
}
OBSERVED = ("output", "latest", "step", "quadrature.dense", "budget", "contact_log")
"""Fields in which an observation leaves something for later: results, dense output and time of a step."""
GARBAGE = 1.7e11


@pytest.mark.full("more cases", but="plain")
@pytest.mark.parametrize("seeds", SEEDS.values(), ids=SEEDS)
def test_impacts_and_counts_do_not_depend_on_the_output_step(seeds):
    differ = []
    for seed in seeds:
        runs = [account(scene(seed), seed, rows=rows) for rows in (1, 53, 997)]
        results = {(run.impacts.tobytes(), str(run.statistics)) for run in runs if not run.refused}
        if len(results) > 1:
            differ.append(seed)
    assert not differ


@pytest.mark.full("more cases", but="plain")
@pytest.mark.parametrize("kind", ["plain", "stops", "friction"])
def test_no_step_reads_what_observing_writes(kind):
    """After each observation the test spoils the real numbers that it changed, except in OBSERVED."""
    spoiled = 0
    for seed in SEEDS[kind]:
        try:
            (expected, _), (result, count) = observed(seed, spoils=False), observed(seed, spoils=True)
        except SimulationError:
            continue
        assert result == expected, seed
        spoiled += count
    assert spoiled > 1000


def observed(seed: int, *, spoils: bool) -> tuple[bytes, int]:
    """Return impacts and counts of a seed's scene as bytes, and the number of spoiled values.

    With ``spoils`` the outputs are read at 97 times, and what this changes is spoiled.
    """
    instance = started(scene(seed), seed)
    stop, impacts, count = instance.prepared_scene.scene.simulation.stop_time, [], 0
    words = [word for name, word in reals(instance.record.dtype) if not name.startswith(OBSERVED)]
    for time in np.linspace(0.0, stop, 98)[1:]:
        if instance.advance(time):
            break
        if spoils:
            count += spoil(instance, words)
        impacts.append(instance.collect())
    impacts.append(instance.open_contacts())
    return np.concatenate(impacts).tobytes() + str(instance.statistics).encode(), count


def spoil(instance: Instance, words: list[int]) -> int:
    """Observe, overwrite those of ``words`` that the observation has changed, and return their number."""
    numbers = instance.words.reshape(-1)
    before = numbers[words]
    instance.observe()
    changed = np.array(words)[numbers[words].view(np.int64) != before.view(np.int64)]
    numbers[changed] = GARBAGE
    return len(changed)


def reals(dtype: np.dtype, name: str = "", start: int = 0) -> Iterator[tuple[str, int]]:
    """Yield the name and the word of each real number in a record."""
    if dtype.subdtype:
        of, shape = dtype.subdtype
        for i in range(int(np.prod(shape))):
            yield from reals(of, name, start + i * of.itemsize)
    elif dtype.names:
        for field in dtype.names:
            part, offset, *_ = dtype.fields[field]
            yield from reals(part, f"{name}.{field}".lstrip("."), start + offset)
    elif dtype.kind == "f":
        yield name, start // 8


# --- folds: no pull, and no energy taken beyond Newton's law -----------------------------------------------


def nearly_folded(angle, spin, **contact):
    """Return two links from floor to floor, the second at an angle, turning: its tip arrives very slowly."""
    initial = {
        "position": [0.0, 0.0],
        "velocity": [0.0, 0.0],
        "angles": [math.pi / 2, angle],
        "angular_velocities": [0.0, spin],
    }
    links = [{"length": LENGTH, "mass": 1.0}] * 2
    table = {"model": "newton_impact", "restitution": 0.0, "points": [0, 2]} | contact
    return build(
        "Fold", links, initial, {"y_min": 0.0}, table, gravity=GRAVITY, stop_time=1e-3, tolerance=1e-8
    )


def test_a_slow_arrival_in_a_fold_takes_no_energy_and_no_wall_pulls():
    """The arrival brings 1e-13 J; impulses of either sign, to stop both points, would dissipate 0.05 J."""
    result = simulate(nearly_folded(-1.5707956778838323, -1.7403405797311131))
    assert (result.impacts["impulse"] >= 0.0).all()
    assert result.impacts["impulse"].max() < 0.1
    assert np.diff(result.outputs["impulse"], axis=0).min() > -1e-6
    assert result.outputs["dissipated"][-1] < 1e-10
    assert result.angular_velocities[-1, 1] == pytest.approx(-1.740, abs=1e-3)


def test_the_motion_after_an_impact_is_continuous_as_the_fold_closes():
    speeds = []
    for offset in np.logspace(-3, -9, 13):
        result = simulate(nearly_folded(-math.pi / 2 + offset, -1.74))
        speeds.append(result.angular_velocities[-1, 1])
        assert result.outputs["dissipated"][-1] < 4.0 * offset**2 + 1e-10
    np.testing.assert_allclose(speeds, -1.74, atol=0.02)


# folds with former faults: a pull at an impact, a loss of energy, a correction of positions that lifted the
# chain, a motion between two phases in which walls hold the chain
FORMER_FINDINGS = [22, 24, 30, 53, 1445, 2215, 2827, 6792, 12742, 16909]


@pytest.mark.parametrize("seed", FORMER_FINDINGS)
def test_a_fold_that_had_faults_has_none(seed):
    assert not faults(fold(seed))


@pytest.mark.full("takes long")
def test_random_folds_keep_newtons_law():
    faults_of_seed = {seed: kinds for seed in range(500) if (kinds := faults(fold(seed)))}
    assert not faults_of_seed
