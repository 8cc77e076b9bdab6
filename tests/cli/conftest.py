"""Fixtures of the command-line tests."""

import io

import pytest

from chain_impact import load_scene
from chain_impact.cli import printing
from chain_impact.compilation.library import kernel_library
from chain_impact.scene.files.models import model_names


@pytest.fixture(scope="package", autouse=True)
def kernels():
    """Compile the models' kernels, so that the other tests do not see messages about compiling."""
    for links in {len(load_scene(name).chain.links) for name in model_names()}:
        kernel_library(links)


@pytest.fixture
def terminal(monkeypatch):
    """Return a function that replaces standard error by a text stream, as a terminal or not."""

    def terminal(is_terminal):
        text = io.StringIO()
        console = printing.plain_console(file=text, force_terminal=is_terminal, width=100)
        monkeypatch.setattr(printing, "err", console)
        return text

    return terminal


@pytest.fixture(params=["scene", "FMU"])
def source(request, fmu):
    """Return the four-link box as a scene and as an FMU."""
    return fmu if request.param == "FMU" else "four_link_box"
