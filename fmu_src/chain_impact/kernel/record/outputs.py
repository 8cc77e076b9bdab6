"""The part of the record with the outputs."""

import numpy as np

from chain_impact.kernel.record.fields import REAL, record, written_by


@written_by("observe.py")
def output_dtype(links: int, candidates: int, elements: int) -> np.dtype:
    """The outputs at the communication point; one row of a time series."""
    points = links + 1
    return record(
        ("point_position", REAL, (points, 2)),  # m
        ("point_velocity", REAL, (points, 2)),  # m/s
        ("point_acceleration", REAL, (points, 2)),  # m/s²
        ("angle", REAL, (links,)),  # rad, absolute, from +x
        ("angular_velocity", REAL, (links,)),  # rad/s
        ("angular_acceleration", REAL, (links,)),  # rad/s²
        ("joint_angle", REAL, (links,)),  # rad, from the link before, of the first one from +x
        ("joint_angular_velocity", REAL, (links,)),  # rad/s, likewise
        ("force", REAL, (candidates,)),  # N, wall on point, along the inward normal
        ("penetration", REAL, (candidates,)),  # m, 0 when apart
        ("penetration_rate", REAL, (candidates,)),  # m/s, > 0 compressing, 0 when apart
        ("impulse", REAL, (candidates,)),  # N·s, of the wall on the point since the start
        ("kinetic", REAL),  # J
        ("potential", REAL),  # J, gravity, zero at the origin
        ("elastic", REAL),  # J, stored in the contacts and in the springs of joints
        ("dissipated", REAL),  # J, by contacts and joint damping since the start
        ("supplied", REAL),  # J, by the inputs since the start
        ("total", REAL),  # J, kinetic + potential + elastic
        ("friction", friction_output_dtype(elements)),
    )


def friction_output_dtype(elements: int) -> np.dtype:
    """The outputs of dry friction, by element."""
    return record(
        ("force", REAL, (elements,)),  # N, of a candidate: wall on point, along t = (n_y, −n_x)
        ("impulse", REAL, (elements,)),  # N·s, likewise, since the start
        ("sticking", REAL, (elements,)),  # 1: the contact sticks
        ("joint_moment", REAL, (elements,)),  # N·m, on the link of each joint; there are fewer than elements
        ("joint_sticking", REAL, (elements,)),  # 1: the joint sticks
        ("dissipated", REAL),  # J, part of `dissipated`
    )
