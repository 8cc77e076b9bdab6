"""The attributes that every recording has: a class of recordings stores or computes them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from chain_impact.recording.joint_stops import JointRange
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.scene.half_planes import HalfPlane


class RecordedAttributes:
    """The attributes of a recording, which are only read.

    A subclass has a field of a dataclass or a property of the same name. Each attribute is a
    ``cached_property`` here, because a dataclass cannot store a field with the name of a property.
    """

    @cached_property
    def name(self) -> str:
        """The name of the scene, of the FMU or of the file."""
        raise NotImplementedError

    @cached_property
    def time(self) -> np.ndarray:
        """The times of the rows, which are communication points, shape (T,) [s]."""
        raise NotImplementedError

    @cached_property
    def columns(self) -> Mapping[str, np.ndarray]:
        """Name of a variable of the FMU → its values, shape (T,)."""
        raise NotImplementedError

    @cached_property
    def impacts(self) -> np.ndarray:
        """One row for each contact in order of onset, see ``IMPACT_DTYPE``.

        For an FMU these are the impacts in its outputs.
        """
        raise NotImplementedError

    @cached_property
    def walls(self) -> Mapping[str, HalfPlane]:
        """Name of a wall → its free side, without the displacement that inputs may give."""
        raise NotImplementedError

    @cached_property
    def wall_names(self) -> tuple[str, ...]:
        """The names of walls and stops; ``impacts`` and ``stick_slip`` have indices into this list."""
        raise NotImplementedError

    @cached_property
    def parameters(self) -> Mapping[str, Any]:
        """Name of a parameter of the FMU → its value at the start.

        For an enumeration the value is the name of the choice. Empty if the values are unknown.
        """
        raise NotImplementedError

    @cached_property
    def sensitivities(self) -> Sensitivities | None:
        """The derivatives that were asked for, or None."""
        raise NotImplementedError

    @cached_property
    def stops(self) -> Mapping[int, JointRange]:
        """Joint → its range, for the joints with stops."""
        raise NotImplementedError

    @cached_property
    def point_names(self) -> Mapping[int, str]:
        """Number of a point → its name, for points with names."""
        raise NotImplementedError

    @cached_property
    def stop_law(self) -> str:
        """The contact law of the stops if the scene gives `stops.model`.

        The text is "" if the scene gives none, or if the law is unknown, as for an FMU.
        """
        raise NotImplementedError

    @cached_property
    def stick_slip(self) -> np.ndarray:
        """The phases of dry friction, see ``STICK_SLIP_DTYPE``.

        For an FMU, their times are accurate to a communication step.
        """
        raise NotImplementedError

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """The names of the inputs that have no column."""
        return ()
