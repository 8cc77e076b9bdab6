"""Instances of fmpy that leave the working folder of the process as it is."""

import os
from pathlib import Path

import pytest

from chain_impact.fmu.importer import keep_working_folder


class Loading:
    def __init__(self, folder):
        os.chdir(folder)
        self.folder = folder


class Plain:
    def __init__(self, folder):
        self.folder = folder


@pytest.mark.parametrize("base", [Loading, Plain])
def test_an_instance_of_a_class_of_fmpy_stays_in_the_working_folder(base, tmp_path):
    """A class that does not change the working folder is used unchanged."""
    kind = type("FMU2Slave", (base,), {})
    folder = Path.cwd()
    still_kind = keep_working_folder(kind)
    assert still_kind(tmp_path).folder == tmp_path
    assert Path.cwd() == folder
    assert (still_kind is kind) == (base is Plain)
