"""Runs in a Python process with changed floating-point registers of the processor."""

# Tests: simulation/simulate.py

import ctypes

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.output_rows import spans_of
from tests.helpers.tools.processors import ON_X86
from tests.helpers.tools.registers import FLUSH, TRAPS, USUAL, WITHOUT_TRAPS, make_library, registers
from tests.tiers import needs_compilers

pytestmark = ON_X86
MODELS = ["four_link_box", "kneed_leg", "sliding_rod"]


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return ctypes.CDLL(str(make_library(tmp_path_factory.mktemp("registers"))))


def whole_run(model):
    """Return the bytes of points, energies and impacts of a run that begins with the scene's file."""
    result = simulate(load_scene(model), stop_time=0.5)
    return [result.points.tobytes(), result.energy.tobytes(), result.impacts.tobytes()]


@needs_compilers
@pytest.mark.parametrize("value", [USUAL | FLUSH, TRAPS], ids=["no denormal numbers", "traps"])
@pytest.mark.parametrize("model", MODELS)
def test_simulate_gives_the_same_bits(library, model, value):
    expected = whole_run(model)
    with registers(library, value):
        result = whole_run(model)
    assert result == expected


@needs_compilers
@pytest.mark.parametrize("model", MODELS)
def test_a_kernel_gives_the_same_bits_whatever_rounds_its_caller(library, model):
    """Record and times are made before the registers change, because Python rounds by them, too."""
    times, bytes_of_rows = np.arange(257) / 512, []
    for value in WITHOUT_TRAPS:
        instance = Instance(load_scene(model))
        rows = np.zeros(len(times), instance.prepared_scene.output_layout)
        spans = spans_of(instance.prepared_scene.output_words)
        library.set_registers(value)
        try:
            instance.initialize()
            count = instance.trajectory(times, rows, spans)
            assert library.registers() == value  # the kernel raises no flag
        finally:
            library.set_registers(USUAL)
        assert count == len(times)
        bytes_of_rows.append(rows.tobytes())
    assert bytes_of_rows == bytes_of_rows[:1] * len(WITHOUT_TRAPS)
