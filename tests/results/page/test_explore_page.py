"""The page that simulates stands alone and is small."""

import re

import numpy as np
import pytest

from chain_impact import load_scene, model_names
from chain_impact.results.page.explore import page
from tests.page_data import data_of

LARGEST = 900_000  # bytes
LONG = {"name": "Long", "chain": {"links": [{"length": 0.1, "mass": 0.1, "count": 40}]}}


@pytest.mark.full("more cases", but=6)
@pytest.mark.parametrize("model", model_names())
def test_the_page_of_every_model_is_small_and_needs_nothing_else(model):
    text = page(load_scene(model), [model])
    assert len(text.encode()) < LARGEST
    others = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)  # without the libraries
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", others)
    assert not re.findall(r"@import|url\((?!data:)|\bfetch\(|XMLHttpRequest", others)
    assert "{{" not in others


def test_the_start_values_are_those_of_the_scene():
    scene = load_scene("four_link_box")
    found = {one["name"]: one for one in data_of(page(scene, []))["parameters"]}
    for name, one in found.items():
        value = scene.values[name]
        assert one["start"] == (scene.law_names.index(value) + 1 if name == "contact.model" else
                                1 if name == "solver.method" else value)  # fmt: skip
    assert found["contact.restitution"]["high"] == 1.0
    assert np.isfinite([one["low"] for one in found.values()]).all()


def test_a_law_has_a_sentence_with_its_range_and_source():
    laws = next(
        one
        for one in data_of(page(load_scene("rod_drop"), []))["parameters"]
        if one["name"] == "contact.model"
    )
    found = dict(laws["items"])
    assert (
        found["zhang_sharf"]
        == "Exact for one contact on its own, for all e. Zhang & Sharf 2009, J Appl Mech 76:051002."
    )
