"""The part of the record with the outputs."""

import numpy as np

from chain_impact.kernel.record.fields import REAL, record, written_by


@written_by("observe.py", load="loads.py")
def output_dtype(links: int, candidates: int, elements: int, loads: int) -> np.dtype:
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
        ("load", load_output_dtype(loads)),
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


def load_output_dtype(loads: int) -> np.dtype:
    """The outputs of loads: a row for each joint, then one for each wall, without impulses and peaks."""
    return record(
        (
            "x",
            REAL,
            (loads,),
        ),  # N, on the link of each joint, of the link before or the ground; or on the wall
        ("y", REAL, (loads,)),
        ("moment", REAL, (loads,)),  # N·m, on the link of each joint, or on the wall about its point
        ("impulse_x", REAL, (loads,)),  # N·s, since the start
        ("impulse_y", REAL, (loads,)),
        ("peak", REAL, (loads,)),  # N, the largest force so far
    )


@written_by("loads.py")
def transmitted_dtype(loads: int) -> np.dtype:
    """What is known of the forces that the joints transmit, with the rows of their outputs."""
    return record(
        ("start_time", REAL),  # s
        ("tip_impulse", REAL, (2,)),  # N·s, of the force at the tip since the start
        ("start_x", REAL, (loads,)),  # N·s, momentum of the links from each on, at the start
        ("start_y", REAL, (loads,)),
        ("peak", REAL, (loads,)),  # N², the largest square of a force until the start of the last step
        ("top", REAL, (loads,)),  # N², likewise, while it is searched for
        ("x", REAL, (loads,)),  # N, forces at a sample, …
        ("y", REAL, (loads,)),
        ("before", REAL, (loads,)),  # N², … and the squares of three in sequence
        ("middle", REAL, (loads,)),
        ("after", REAL, (loads,)),
    )
