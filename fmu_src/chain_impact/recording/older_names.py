"""Older names of the attributes of a recording."""

from __future__ import annotations

from chain_impact.deprecated import OlderName


class OlderNames:
    """The older names of attributes of ``Recording``."""

    at = OlderName("with_rows")
    at_stops = OlderName("is_at_joint_stop")
    end_speeds = OlderName("linear_impact_speeds")
    in_other_run = OlderName("row_of_other_run")
    is_stop = OlderName("is_joint_stop")
    loads = OlderName("joint_forces")
    passing = OlderName("points_through_walls")
    spot = OlderName("impact_position")
    toucher = OlderName("touching_part")
    touches = OlderName("interactions")
    touching = OlderName("touching_radii")
