"""Measured motions: the models' distances from the measurements, the files of measured values, the charts."""

import numpy as np
import pytest
from PIL import Image

from chain_impact import simulate
from tests.helpers.literature import beside_measurements
from tests.helpers.literature.measured import heard_impacts, measured

MODELS = ("golf_ball", "triple_pendulum")


@pytest.mark.parametrize("model", MODELS)
def test_measured_values_have_the_names_of_the_fmu(model):
    columns, result = measured(model), simulate(model)
    for name in columns:
        assert np.isfinite(columns[name]).all()
        if name != "time":
            assert result[name].shape == result.time.shape
    assert (np.diff(columns["time"]) > 0).all()
    assert columns["time"][-1] <= result.time[-1]


def test_the_triple_pendulum_swings_as_measured():
    columns, result = measured("triple_pendulum"), simulate("triple_pendulum")
    assert result.time == pytest.approx(columns["time"], abs=1e-9)
    angles = np.stack([columns[f"link[{i}].angle"] for i in (1, 2, 3)])
    off = np.abs(angles - result.angles.T)
    # docs/models/triple_pendulum.md gives the largest distances
    assert np.ptp(angles, axis=1) == pytest.approx([0.86, 1.10, 2.18], abs=5e-3)
    assert off[:, columns["time"] <= 2.0].max() == pytest.approx(0.008, abs=5e-4)
    assert off.max(axis=1) == pytest.approx([0.026, 0.030, 0.044], abs=6e-4)
    assert np.sqrt((off**2).mean(axis=1)) == pytest.approx([0.009, 0.011, 0.016], abs=6e-4)


def test_the_golf_ball_bounces_as_heard():
    onsets, heard = simulate("golf_ball").impacts["onset"], heard_impacts()
    assert len(onsets) == len(heard) == 9
    early = heard - onsets
    # docs/models/golf_ball.md: the simulated impacts come earlier and earlier
    assert early[0] == pytest.approx(0.0, abs=1e-5)
    assert early[[1, 2, 8]] == pytest.approx([0.0015, 0.0037, 0.066], abs=1e-3)
    assert (np.diff(early) > 0).all()


def test_heights_of_the_golf_ball_follow_from_the_measured_times():
    columns, heard = measured("golf_ball"), heard_impacts()
    time, height = columns["time"], columns["point[0].y"]
    flights = np.diff(heard)
    # a free flight of the duration T from floor to floor has the height g T²/8 in its middle
    assert height[time < heard[0]] == pytest.approx([9.81 / 2 * heard[0] ** 2], abs=1e-4)
    tops = height[(time > heard[0]) & (height > 0)]
    assert tops == pytest.approx(9.81 * flights**2 / 8, abs=2e-5)
    assert time[(time > heard[0]) & (height > 0)] == pytest.approx((heard[1:] + heard[:-1]) / 2, abs=2e-5)


@pytest.mark.full("takes long")
def test_the_charts_are_drawn(tmp_path):
    beside_measurements.draw(tmp_path)
    assert {file.stem for file in tmp_path.iterdir()} == {*MODELS, "steel_bar"}
    for file in tmp_path.iterdir():  # the picture in the docs shows the same text
        with Image.open(file) as now, Image.open(beside_measurements.IMAGES / file.name) as committed:
            assert committed.text == now.text
