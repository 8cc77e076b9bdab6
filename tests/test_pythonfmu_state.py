"""pythonfmu's state is released once, and whatever is no FMU of it is left alone."""

import ctypes
import zipfile

import fmpy
import pytest

from chain_impact import build_fmu, load_scene
from chain_impact.pythonfmu_state import release
from chain_impact.runs import record_fmu


@pytest.fixture(params=["pythonfmu", "native"])
def fmu(request, tmp_path):
    return build_fmu(load_scene("rod_drop"), tmp_path, target=request.param)


def test_it_is_released_after_a_simulation(fmu, monkeypatch):
    released = []

    def library(path):
        loaded = ctypes.cdll.LoadLibrary(path)
        released.append(hasattr(loaded, "finalizePythonInterpreter"))
        return loaded

    monkeypatch.setattr(ctypes, "CDLL", library)
    record_fmu(fmu)
    assert released[-1] == ("pythonfmu" in fmpy.read_model_description(str(fmu)).generationTool.lower())


def test_to_release_it_again_does_no_harm(fmu, tmp_path):
    description = fmpy.read_model_description(str(fmu))
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path / "unpacked")
    for _ in range(3):
        release(tmp_path / "unpacked", description)
        assert record_fmu(fmu).impact_count == 30


def test_a_library_that_cannot_be_loaded_is_left_alone(fmu, tmp_path):
    description = fmpy.read_model_description(str(fmu))
    release(tmp_path / "nowhere", description)
    folder = tmp_path / "broken" / "binaries" / fmpy.platform
    folder.mkdir(parents=True)
    (folder / "RodDrop.so").write_bytes(b"no library")
    release(tmp_path / "broken", description)
