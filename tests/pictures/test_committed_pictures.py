"""The committed pictures of models: their texts equal the texts that the code draws."""

# Tests: pictures/drawing/style.py

import re
from pathlib import Path

import pytest
from PIL import Image

from chain_impact.pictures.drawing.style import metadata_of
from chain_impact.scene.files.models import model_names
from docs.tools.images import OTHERS
from tests.pictures.pictures import page_of, recorded

IMAGES = Path(__file__).parents[2] / "docs" / "images"
NUMBERS = re.compile(r"([#\d, –+…]|more)+")


def lines(words):
    """Return the words of a picture without the numbers of impacts, which may not fit, and without line ends.

    Whether a label that is as long as its axis has one line or two depends on the resolution of the figure.
    """
    told = words["Description"].split("\n")
    kept = [line for line in told if not NUMBERS.fullmatch(line)]
    return " ".join(kept).split()


@pytest.mark.full("more cases", but="arm_at_stop")
@pytest.mark.parametrize("model", sorted({*model_names()} - OTHERS))
def test_the_picture_of_a_model_says_what_the_code_says(model):
    now = metadata_of(page_of(recorded(model))[0])
    with Image.open(IMAGES / f"{model}.png") as picture:
        assert picture.text["Title"] == now["Title"]
        assert lines(picture.text) == lines(now)
