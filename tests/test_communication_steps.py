"""A run does not depend on when it is observed: impacts and counts are the same, bit for bit."""

from collections.abc import Iterator

import numpy as np
import pytest

from chain_impact.simulation.instance import Instance, SimulationError
from tests.oracle import account
from tests.random_scenes import FOLDED, RUBBED, SLANTED, SPRUNG, STOPPED, TAUT, UNEVEN, scene, started

EACH = 65  # scenes of each kind
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
    }.items()
}
OBSERVED = ("output", "latest", "step", "impulse.dense", "friction_impulse.dense", "limits", "finished")
"""What observing is for, and what of the last step it may make known: its dense output, and the time."""
GARBAGE = 1.7e11


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("seeds", SEEDS.values(), ids=SEEDS)
def test_impacts_and_counts_do_not_depend_on_the_output_step(seeds):
    differ = []
    for seed in seeds:
        runs = [account(scene(seed), seed, rows=rows) for rows in (1, 53, 997)]
        results = {(run.impacts.tobytes(), str(run.statistics)) for run in runs if not run.refused}
        if len(results) > 1:
            differ.append(seed)
    assert not differ


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("kind", ["plain", "stops", "friction"])
def test_no_step_reads_what_observing_writes(kind):
    """After each look at the motion, all that it has written is overwritten, and the run is the same."""
    spoiled = 0
    for seed in SEEDS[kind][:20]:
        try:
            (expected, _), (found, count) = observed(seed, spoils=False), observed(seed, spoils=True)
        except SimulationError:
            continue
        assert found == expected, seed
        spoiled += count
    assert spoiled > 1000


def observed(seed: int, *, spoils: bool) -> tuple[bytes, int]:
    """The results of the scene of a seed, looked at many times, and how many numbers were overwritten."""
    instance = started(scene(seed), seed)
    stop, impacts, count = instance.model.scene.simulation.stop_time, [], 0
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
    """Observe, and overwrite those of some words that this has changed; return how many."""
    numbers = instance.words.reshape(-1)
    before = numbers[words]
    instance.observe()
    changed = np.array(words)[numbers[words].view(np.int64) != before.view(np.int64)]
    numbers[changed] = GARBAGE
    return len(changed)


def reals(dtype: np.dtype, name: str = "", start: int = 0) -> Iterator[tuple[str, int]]:
    """The name and the word of each real number in a record."""
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
