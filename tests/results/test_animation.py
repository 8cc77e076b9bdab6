"""The function write_animation(): the file suffix selects the kind; refused arguments."""

import sys

import numpy as np
import pytest

from chain_impact.extras import MissingExtraError
from chain_impact.recording.recording import Recording
from chain_impact.results.animation import AnimationError, write_animation

BEGINNINGS = {".html": b"<!doctype html>", ".gif": b"GIF89a"}


def swing(rows=20):
    """Return a recording of a rod of 1 m that turns about the origin, without walls."""
    time = np.linspace(0.0, 0.5, rows)
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(time), "point[1].y": np.sin(time), "energy.total": 1 + time}
    return Recording("Swing", time, columns)


@pytest.mark.parametrize("suffix", BEGINNINGS)
def test_the_suffix_says_which_kind_of_file(tmp_path, suffix):
    path, fractions = tmp_path / f"swing{suffix}", []
    write_animation(swing(), path, size=(320, 180), progress=fractions.append)
    assert path.read_bytes().startswith(BEGINNINGS[suffix])
    assert list(tmp_path.iterdir()) == [path]
    assert fractions[-1] == 1.0


@pytest.mark.parametrize(
    ("arguments", "pattern"),
    [
        ({"path": "swing.avi"}, r"swing\.avi: the name must end in \.html, \.gif, \.mp4"),
        ({"speed": 0.0}, "speed = 0 must be a finite number > 0"),
        ({"speed": float("inf")}, "speed = inf must be"),
        ({"impact_time": -1.0}, r"impact_time = -1 must be a finite number >= 0 \[s\]"),
        (
            {"path": "swing.gif", "size": (-320, 180)},
            r"size = \(-320, 180\): width and height must be 160 … 4096",
        ),
        ({"recording": swing(1)}, "Swing: an animation needs two rows at least"),
    ],
)
def test_wrong_arguments_of_animate_are_refused(tmp_path, arguments, pattern):
    arguments = {"recording": swing(), **arguments}
    arguments["path"] = tmp_path / arguments.get("path", "swing.html")
    with pytest.raises(AnimationError, match=pattern):
        write_animation(**arguments)
    assert list(tmp_path.iterdir()) == []


def test_an_mp4_without_pyav_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(MissingExtraError, match=r"^av is not installed: .*pip install '(av<|.*\[video\])"):
        write_animation(swing(), tmp_path / "swing.mp4", size=(320, 180))
    assert list(tmp_path.iterdir()) == []
