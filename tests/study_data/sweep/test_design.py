"""Designs of sweeps: grids contain all combinations, samples fill the space evenly; both are limited."""

import itertools
import math

import numpy as np
import pytest

from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import load_scene
from chain_impact.study_data.sweep.design import (
    CUBE,
    MOST_CELLS,
    MOST_SOBOL,
    check_table_size,
    grid_design,
    sampled_design,
)
from chain_impact.study_data.sweep.variation import variations_of

SCENE = load_scene("four_link_box")
INTERVALS = {"contact.restitution": "0.2:0.8", "contact.stiffness": "1e6:1e9:log"}


def test_a_grid_is_all_combinations_in_order():
    design = grid_design(
        variations_of(SCENE, {"contact.restitution": "0:1:3", "contact.model": "1,2,4"}), "s"
    )
    assert design.runs == 9
    assert design.values(0, 9).tolist() == [list(p) for p in itertools.product((0, 0.5, 1), (1, 2, 4))]
    assert design.values(4, 6).tolist() == [[0.5, 2.0], [0.5, 4.0]]


def test_a_grid_needs_numbers_of_values():
    with pytest.raises(SceneError, match=r"contact.restitution = 0.2:0.8 is an interval.*0.2:0.8:9"):
        grid_design(variations_of(SCENE, INTERVALS), "s")


@pytest.mark.parametrize("sampling", ["lhs", "sobol"])
@pytest.mark.parametrize("count", [1, 10, 64])
def test_samples_fill_the_space(sampling, count):
    variations = variations_of(SCENE, INTERVALS)
    design = sampled_design(variations, "s", count=count, sampling=sampling, seed=3)
    e, k = design.values(0, count).T
    assert design.runs == len(e) == count
    parts = np.array([(e - 0.2) / 0.6, np.log10(k / 1e6) / 3.0])
    assert ((parts >= 0.0) & (parts <= 1.0)).all()
    if sampling == "lhs" or count == 64:  # one sample in each of the equal parts of every axis
        assert (np.sort((parts * count).astype(int)) == np.arange(count)).all()
    same_seed_values, other_seed_values = (
        sampled_design(variations, "s", count=count, sampling=sampling, seed=seed).values(0, count)
        for seed in (3, 4)
    )
    assert (same_seed_values == design.values(0, count)).all()
    assert (other_seed_values != design.values(0, count)).all()


@pytest.mark.parametrize(
    ("count", "sampling", "seed", "words"),
    [
        (0, "lhs", 0, "samples = 0 must be a whole number >= 1"),
        (1.5, "lhs", 0, "samples = 1.5 must be a whole number"),
        (9, "lhs", -1, "seed = -1 must be a whole number >= 0"),
        (9, "halton", 0, "sampling = 'halton' must be lhs or sobol"),
        (MOST_SOBOL + 1, "sobol", 0, f"samples = {MOST_SOBOL + 1} must be a whole number >= 1 and < "),
    ],
)
def test_wrong_designs_are_refused(count, sampling, seed, words):
    with pytest.raises(SceneError, match=f"^s: .*{words}"):
        sampled_design(variations_of(SCENE, INTERVALS), "s", count=count, sampling=sampling, seed=seed)


@pytest.mark.parametrize("sampling", ["lhs", "sobol"])
@pytest.mark.parametrize("count", [1, 10, 1000, 3001])
def test_samples_are_scipys_whatever_block_is_asked_for(sampling, count):
    """Samples of a seed never change, because no state is kept between blocks."""
    from scipy.stats import qmc  # here, because the import takes half a second

    variations, generator = variations_of(SCENE, INTERVALS), np.random.default_rng(7)
    if sampling == "lhs":
        parts = qmc.LatinHypercube(2, seed=generator).random(count)
    else:
        parts = qmc.Sobol(2, seed=generator).random_base2(math.ceil(math.log2(count)))[:count]
    expected = np.stack(
        [variation.values_at(part) for variation, part in zip(variations, parts.T, strict=True)], axis=1
    )
    design = sampled_design(variations, "s", count=count, sampling=sampling, seed=7)
    for first, end in ((0, count), (count // 2, count), (count // 3, count // 2 + 1), (0, 1)):
        assert (design.values(first, end) == expected[first:end]).all()


def test_very_many_samples_are_latin_hypercubes_one_after_another():
    variations = variations_of(SCENE, INTERVALS)
    design = sampled_design(variations, "s", count=10**9, sampling="lhs", seed=0)
    assert design.runs == 10**9
    for cube, first, size in ((0, 0, CUBE), (15000, 15000 * CUBE, CUBE), (15258, 15258 * CUBE, 10**9 % CUBE)):
        values = design.values(first, first + size)
        parts = (values[:, 0] - 0.2) / 0.6
        # rounding may put a few samples into the next part
        assert (np.sort((parts * size).astype(int)) == np.arange(size)).mean() > 0.99, cube
        assert (design.values(first + 5, first + 9) == values[5:9]).all()
        values_across_cubes = design.values(first - 3, first + 3)[3:] if first else values[:3]
        assert (values_across_cubes == values[:3]).all()


def test_a_grid_that_is_too_large_is_refused_before_it_is_made():
    fine = dict.fromkeys(("contact.restitution", "initial.x", "initial.y"), "0.1:0.9:100000")
    design = grid_design(variations_of(SCENE, fine), "s")
    with pytest.raises(SceneError, match=r"^s: 1000000000000000 runs with 20 columns .*or write a folder"):
        check_table_size(design, 20, "s", streamed=False)
    check_table_size(design, 20, "s", streamed=True)
    assert (design.values(10**15 - 1, 10**15) == 0.9).all()
    finer = grid_design(variations_of(SCENE, {**fine, "initial.vx": "1:2:2"}), "s")
    with pytest.raises(SceneError, match=r"^s: 2000000000000000 runs must be <= 1000000000000000"):
        check_table_size(finer, 20, "s", streamed=True)
    samples = sampled_design(
        variations_of(SCENE, INTERVALS), "s", count=MOST_CELLS // 20, sampling="lhs", seed=0
    )
    check_table_size(samples, 20, "s", streamed=False)
    with pytest.raises(SceneError, match="5000000 runs with 21 columns are 105000000 numbers"):
        check_table_size(samples, 21, "s", streamed=False)
