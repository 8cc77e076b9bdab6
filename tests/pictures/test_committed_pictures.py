"""The committed pictures of models: their texts equal the texts that the code draws."""

# Tests: pictures/drawing/picture_files.py

import re
from pathlib import Path

import pytest
from PIL import Image

from chain_impact.pictures.drawing.picture_files import picture_metadata
from chain_impact.scene.files.models import model_names
from docs.tools.images import MODELS_OF_PROGRAMS
from tests.pictures.pictures import page_of, recorded

IMAGES = Path(__file__).parents[2] / "docs" / "images"
NUMBERS = re.compile(r"([#\d, –+…]|more)+")


def lines(words):
    """Return the words of a picture without the numbers of impacts, which may not fit, and without line ends.

    Whether a label that is as long as its axis has one line or two depends on the resolution of the figure.
    """
    all_lines = words["Description"].split("\n")
    text_lines = [line for line in all_lines if not NUMBERS.fullmatch(line)]
    return " ".join(text_lines).split()


@pytest.mark.full("more cases", but="arm_at_stop")
@pytest.mark.parametrize("model", sorted({*model_names()} - MODELS_OF_PROGRAMS))
def test_the_picture_of_a_model_says_what_the_code_says(model):
    metadata = picture_metadata(page_of(recorded(model))[0])
    with Image.open(IMAGES / f"{model}.png") as picture:
        assert picture.text["Title"] == metadata["Title"]
        assert lines(picture.text) == lines(metadata)
