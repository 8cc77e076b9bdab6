"""FMUs of scenes with points on links, an offset of a centre of mass, and a slider."""

# Tests: fmu/scene_data.py, fmu/run.py, variables/outputs.py

import re
import zipfile

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.fmu.run import record_fmu
from chain_impact.fmu.scene_data import read_scene_data
from tests.fmu.clean import importing
from tests.fmu.importer import Instance
from tests.fmu.scenes import scene_of

STEP = 2.0**-7  # s; sums of this step are exact
STOP = 0.75  # s
CHANGES = {
    "body": (
        {
            "link[1].center_of_mass_offset": -0.03,
            "link[1].point[1].y": -0.125,
            "link[1].point[2].radius": 0.02,
            "link[2].length": 0.3,
            "link[2].height": 0.06,
        },
        {},
    ),
    "cart": ({"slider.angle": 0.125, "slider.mass": 2.5, "slider.max": 0.25}, {"slider.force": 1.5}),
}
"""Scene → parameters, and constant inputs."""


def trajectory(fmu, values, inputs, stop, step):
    instance = Instance(fmu).start(**values | inputs)
    times = [i * step for i in range(round(stop / step) + 1)]
    return [instance.outputs, instance.run(times)]


@pytest.mark.parametrize("model", CHANGES)
def test_every_output_is_that_of_a_simulation(fmus, clean, model):
    values, inputs = CHANGES[model]
    result = simulate(scene_of(model).with_values(values), STOP, STEP, inputs=inputs)
    names, rows = clean(trajectory, fmus[model], values, inputs, STOP, STEP)
    fmu_columns = dict(zip(names, np.transpose(rows), strict=True))
    for name, column in result.prepared_scene.series(result.outputs).items():
        np.testing.assert_array_equal(fmu_columns[name], column, err_msg=name)
    assert fmu_columns["impact.count"][-1] == len(result.impacts) > 0


@pytest.mark.parametrize(
    ("model", "save_at"),
    [
        ("body", "contact[3].y_min.force"),
        ("body", 0.5),
        ("cart", "contact[0].slider_max.force"),
        ("cart", 0.25),
    ],
)
@importing()
def test_a_saved_state_goes_on_to_the_last_bit(fmu, save_at):
    first, second = Instance(fmu).start(), Instance(fmu)
    if isinstance(save_at, str):
        while not first[save_at]:
            first.step(first.time + 2e-4)
    else:
        first.step(save_at)
    data = first.fmu.serializeFMUstate(first.fmu.getFMUstate())
    times = [first.time + 1e-3 * i for i in range(1, 51)]
    second.fmu.setFMUstate(second.fmu.deSerializeFMUstate(data))
    second.time = first.time
    assert first.run(times) == second.run(times)


def test_a_run_of_an_fmu_tells_points_by_their_names(fmus):
    run = record_fmu(fmus["body"], {"simulation.stop_time": 0.4})
    assert run.point_names == {3: "heel", 4: "toe"}
    assert run.touching_part(run.impacts[0]) == "point 3 (heel)"


def test_names_of_points_and_rules_do_not_follow_from_descriptions(fmus, tmp_path):
    bare = tmp_path / "bare.fmu"
    with zipfile.ZipFile(fmus["body"]) as source_zip, zipfile.ZipFile(bare, "w") as target_zip:
        for name in source_zip.namelist():
            content = source_zip.read(name)
            if name == "modelDescription.xml":
                content = re.sub(rb' description="[^"]*"', b"", content)
            target_zip.writestr(name, content)
    run, bare_run = (record_fmu(fmu, {"simulation.stop_time": 0.01}) for fmu in (fmus["body"], bare))
    assert bare_run.point_names == run.point_names
    assert bare_run.parameters == run.parameters
    assert read_scene_data(bare).rules
