"""Grids are all combinations, samples fill the space evenly; both are bounded."""

import itertools

import numpy as np
import pytest

from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import load_scene
from chain_impact.studies.sweep.design import MOST_NUMBERS, grid, sampled
from chain_impact.studies.sweep.variation import variations_of

SCENE = load_scene("four_link_box")
INTERVALS = {"contact.restitution": "0.2:0.8", "contact.stiffness": "1e6:1e9:log"}


def test_a_grid_is_all_combinations_in_order():
    design = grid(variations_of(SCENE, {"contact.restitution": "0:1:3", "contact.model": "1,2,4"}), 20, "s")
    assert len(design) == 9
    assert design.values(0, 9).tolist() == [list(p) for p in itertools.product((0, 0.5, 1), (1, 2, 4))]
    assert design.values(4, 6).tolist() == [[0.5, 2.0], [0.5, 4.0]]


def test_a_grid_needs_numbers_of_values():
    with pytest.raises(SceneError, match=r"contact.restitution = 0.2:0.8 is an interval.*0.2:0.8:9"):
        grid(variations_of(SCENE, INTERVALS), 20, "s")


@pytest.mark.parametrize("sampling", ["lhs", "sobol"])
@pytest.mark.parametrize("count", [1, 10, 64])
def test_samples_fill_the_space(sampling, count):
    variations = variations_of(SCENE, INTERVALS)
    design = sampled(variations, 20, "s", count=count, sampling=sampling, seed=3)
    e, k = design.values(0, count).T
    assert len(design) == len(e) == count
    parts = np.array([(e - 0.2) / 0.6, np.log10(k / 1e6) / 3.0])
    assert ((parts >= 0.0) & (parts <= 1.0)).all()
    if sampling == "lhs" or count == 64:  # one sample in each of the equal parts of every axis
        assert (np.sort((parts * count).astype(int)) == np.arange(count)).all()
    again, other = (
        sampled(variations, 20, "s", count=count, sampling=sampling, seed=seed).samples for seed in (3, 4)
    )
    assert (again == design.samples).all()
    assert (other != design.samples).all()


@pytest.mark.parametrize(
    ("count", "sampling", "seed", "words"),
    [
        (0, "lhs", 0, "samples = 0 must be a whole number >= 1"),
        (1.5, "lhs", 0, "samples = 1.5 must be a whole number"),
        (9, "lhs", -1, "seed = -1 must be a whole number >= 0"),
        (9, "halton", 0, "sampling = 'halton' must be lhs or sobol"),
        (MOST_NUMBERS // 20 + 1, "lhs", 0, "runs with 20 columns are .* numbers, must be <= 100000000"),
    ],
)
def test_refused(count, sampling, seed, words):
    with pytest.raises(SceneError, match=f"^s: .*{words}"):
        sampled(variations_of(SCENE, INTERVALS), 20, "s", count=count, sampling=sampling, seed=seed)


def test_a_grid_that_is_too_large_is_refused_before_it_is_made():
    fine = dict.fromkeys(("contact.restitution", "initial.x", "initial.y"), "0.1:0.9:100000")
    with pytest.raises(SceneError, match="1000000000000000 runs"):
        grid(variations_of(SCENE, fine), 20, "s")
