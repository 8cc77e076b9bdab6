"""A record of plain Python that knows to which state each group of values belongs.

The link vectors, the places with their velocities, the accelerations, and the forces of contacts and of dry
friction are valid for one state, and the next evaluation overwrites them. Here each group carries a stamp:
the numbers of its state. A read is stale if the reader has another state: its own ``y``, or the state of the
groups that it reads together with this group.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial, wraps
from types import FrameType
from typing import Any
from unittest import mock

import numpy as np

from chain_impact.kernel.chain import kinematics, prescribed_motion
from chain_impact.kernel.record.constants import NO_FRICTION
from chain_impact.kernel.record.state import FIRST_ANGLE, coordinate_count, state_length, time_at
from tests.helpers.kernel.plain import Plain, as_plain_python

GROUPS = ("link_vector", "position", "velocity", "acceleration")
CALLERS = 3
"""The number of functions, the reader and its callers, in which a state ``y`` is looked for."""
AT_END = ("latch_onset", "find_lone_contact", "update_extremes", "choose_friction_modes")
"""The functions without an argument y that need the points at the end of the last step."""
LINEAR = ("project_coordinates",)
"""The functions that move y, and are linear about the points located before."""
BESIDE = ("work_of_holding", "work_of_sliding", "work_along")
"""The functions that use forces of friction of another state, which differs only by an error."""


class StaleError(AssertionError):
    """A function has read a value that belongs to another state."""


class Stamps:
    """The states to which the groups of an instance belong, as bytes."""

    def __init__(self, d: Plain) -> None:
        self.d = d
        self.links = self.places = self.accelerations = b""
        self.moved = 0.0

    def links_of(self, y: np.ndarray) -> bytes:
        """Return the part of a state on which the link vectors depend."""
        return y[FIRST_ANGLE : FIRST_ANGLE + self.d.link_count].tobytes()

    def places_of(self, y: np.ndarray) -> bytes:
        """Return the part of a state on which places and velocities depend."""
        return y[: 2 * coordinate_count(self.d.link_count)].tobytes()

    def rubs_not(self, e: int) -> bool:
        """Return whether element e has no friction, and the force 0 in every state."""
        element = self.d.numpy_record["friction_element"]
        return bool(element["mode"][e] == NO_FRICTION and element["force"][e] == 0.0)

    def check(self, group: str, stamp: bytes | None) -> None:
        """Raise a StaleError if a function reads a group whose stamp is that of another state."""
        reader = sys._getframe(2)
        if group == "friction" and reader.f_code.co_name in BESIDE:
            return
        y = self._state_of(reader)
        angles = self.places[8 * FIRST_ANGLE :][: len(self.links)]
        if group == "link_vector":
            stale = y is not None and self.links != self.links_of(y)
        else:
            stale = self.links != angles or stamp != self.places
            stale = stale or (y is not None and self.places != self.places_of(y))
            stale = stale or (y is not None and self.d.channel_count > 0 and self.moved != self._time_of(y))
        if stale:
            names = [frame.f_code.co_name for frame in _outward(reader, 6)]
            raise StaleError(f"{group} of another state: {' < '.join(names)}")

    def _time_of(self, y: np.ndarray) -> float:
        return float(self.d.step.time_origin + y[time_at(self.d.link_count)])

    def _state_of(self, reader: FrameType) -> np.ndarray | None:
        """Return the state y of the innermost of a reader and its callers that has one; None without any.

        Functions in LINEAR have none; those in AT_END have the state at the end of the last step.
        """
        for frame in _outward(reader, CALLERS):
            if frame.f_code.co_name in LINEAR:
                return None
            if frame.f_code.co_name in AT_END:
                end: np.ndarray = self.d.step.state_end
                return end
            y, of_vectors = frame.f_locals.get("y"), isinstance(frame.f_locals.get("x"), np.ndarray)
            if isinstance(y, np.ndarray) and y.shape == (state_length(self.d.link_count),) and not of_vectors:
                return y
        return None


def _outward(frame: FrameType | None, most: int) -> Iterator[FrameType]:
    """Yield a frame and those of its callers, at most so many, until one is not of the kernel."""
    while frame and most and frame.f_globals["__name__"].startswith("chain_impact.kernel"):
        yield frame
        frame, most = frame.f_back, most - 1


class Stamped(np.ndarray):
    """The numbers of a group. A read of a single number checks the stamp."""

    stamps: Stamps | None = None
    group = ""
    written: dict[Any, bytes] | None = None
    """Index → stamp, in a group that is written number by number."""

    def __getitem__(self, at: Any) -> Any:
        of_one = self.stamps is not None and np.ndim(at) == 0 and not isinstance(at, slice)
        if of_one and not (self.group == "friction" and self.stamps.rubs_not(at)):
            own, group = self.stamps, self.group
            stamp = own.accelerations if group == "acceleration" else own.places
            own.check(group, stamp if self.written is None else self.written.get(int(at)))
        return super().__getitem__(at)

    def __setitem__(self, at: Any, value: Any) -> None:
        if self.stamps is not None and self.written is not None:
            for k in np.ravel(np.arange(len(self))[at]):
                self.written[int(k)] = self.stamps.places
        super().__setitem__(at, value)


def stamp(d: Plain) -> None:
    """Let the groups of an instance carry stamps, which functions write while they are ``watched``."""
    stamps, scratch = Stamps(d), d.scratch
    groups = [(getattr(scratch, group), axis, group) for group in GROUPS for axis in "xy"]
    forces = [
        (d.contacts, "force", "contact"),
        *([(d.friction_element, "force", "friction")] if d.friction_element_count else []),
    ]
    for part, field, group in groups + forces:
        numbers = getattr(part, field).view(Stamped)
        numbers.stamps, numbers.group = stamps, group
        numbers.written = {} if field == "force" else None
        object.__setattr__(part, field, numbers)
    object.__setattr__(d, "stamps", stamps)


def _links(stamps: Stamps, y: np.ndarray) -> None:
    stamps.links = stamps.links_of(y)


def _places(stamps: Stamps, y: np.ndarray) -> None:
    stamps.places = stamps.places_of(y)


def _accelerations(stamps: Stamps, y: np.ndarray, _rate: np.ndarray) -> None:
    stamps.accelerations = stamps.places_of(y)


def _moved(stamps: Stamps, time: float) -> None:
    stamps.moved = float(time)


WRITERS: dict[Callable[..., Any], Callable[..., None]] = {
    kinematics.set_link_vectors: _links,
    kinematics.locate_from_link_vectors: _places,
    kinematics.accelerate_points: _accelerations,
    prescribed_motion.move_channels: _moved,
}
"""Function of the kernel that writes a group → the function that writes the stamp."""


def _with_stamp(function: Callable[..., Any], d: Any, *rest: Any) -> Any:
    if "stamps" in vars(d):
        WRITERS[function](d.stamps, *rest)
    return function(d, *rest)


@contextmanager
def watched() -> Iterator[None]:
    """Let the kernel run as plain Python, and write the stamps of instances that carry them."""
    with ExitStack() as stack:
        stack.enter_context(as_plain_python())
        for module in [sys.modules[name] for name in sys.modules if name.startswith("chain_impact.kernel")]:
            for name, function in vars(module).copy().items():
                if callable(function) and function in WRITERS:
                    with_stamp = wraps(function)(partial(_with_stamp, function))
                    stack.enter_context(mock.patch.object(module, name, with_stamp))
        yield
