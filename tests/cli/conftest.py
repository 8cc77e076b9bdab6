"""The kernels of the models: what the command line says of compiling them is no matter of most tests."""

import pytest

from chain_impact import load_scene
from chain_impact.compilation.library import kernel_library
from chain_impact.scene.scene import model_names


@pytest.fixture(scope="package", autouse=True)
def kernels():
    """See that they are compiled."""
    for links in {len(load_scene(name).chain.links) for name in model_names()}:
        kernel_library(links)
