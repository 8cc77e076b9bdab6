"""The page stands alone and is small; its modules fit together."""

import re
from collections import Counter

import numpy as np
import pytest

from chain_impact import load_scene, model_names
from chain_impact.results.animation import page as player
from chain_impact.results.explore.page import MODULES, PAGE, STYLES, WORKER, page, program, source
from tests.page_data import data_of

LARGEST = 900_000  # bytes
LONG = {"name": "Long", "chain": {"links": [{"length": 0.1, "mass": 0.1, "count": 40}]}}
DEFINED = re.compile(r"^(?:const|let|class|(?:async )?function\*?) (\w+)", re.MULTILINE)


@pytest.mark.full("more cases", but=6)
@pytest.mark.parametrize("model", model_names())
def test_the_page_of_every_model_is_small_and_needs_nothing_else(model):
    text = page(load_scene(model), [model])
    assert len(text.encode()) < LARGEST
    others = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)  # without the libraries
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", others)
    assert not re.findall(r"@import|url\((?!data:)|\bfetch\(|XMLHttpRequest", others)
    assert "{{" not in others


def test_no_name_of_a_module_hides_that_of_another():
    """They are put one after the other, as one module."""
    for text in (program(WORKER), "\n".join([player.player(), program(MODULES)])):
        assert [name for name, count in Counter(DEFINED.findall(text)).items() if count > 1] == []


def test_the_folder_holds_what_the_page_is_made_of():
    files = {file.name for file in PAGE.iterdir()}
    own = {*WORKER, *MODULES} - {*player.PLAYER}
    assert files == {"index.html", *STYLES, *(f"{name}.js" for name in own)}


def test_modules_import_from_those_before_them_only():
    for names, before in ((WORKER, ()), (MODULES, player.PLAYER)):
        for place, name in enumerate(names):
            imported = re.findall(r'from "\./(\w+)\.js"', source(name))
            assert set(imported) <= {*before, *names[:place]}, name


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
