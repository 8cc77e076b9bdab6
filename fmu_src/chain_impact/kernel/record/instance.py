"""The layout of an instance, a flat record of all data of a running simulation, and the layouts of outputs.

Parameters, inputs, the integrator's memory, statistics, outputs and scratch memory are the fields of one
NumPy record without pointers, so the state of an FMU is a copy of the record's bytes. Every number takes
eight bytes (a double or an integer) or, if complex, sixteen. So the code of an FMU finds each number by an
index, counted in words of eight bytes from the start of the record, and needs no other knowledge of the
layout.

Points are numbered 0…N: 0 is the base, N is the tip. Sites follow, from N + 1. kernel/record/state.py
describes the state vector y.

Every size and offset is an affine function of the counts (counts.py): a constant plus a multiple of each
count. The compiled kernel relies on this (compilation/record_type.py). The offset of a field depends on the
sizes of the fields before it, so the fields that every chain has come first. Fields of candidates, of dry
friction, of transmitted forces, channels, sites and signals follow.
"""

import numpy as np

from chain_impact.kernel.record.contacts import (
    candidate_dtype,
    constraints_dtype,
    contact_log_dtype,
    contacts_dtype,
    impact_dtype,
    latest_dtype,
    law_dtype,
    limited_forces_dtype,
    peaks_dtype,
    quadrature_dtype,
)
from chain_impact.kernel.record.counts import COUNTS, Counts
from chain_impact.kernel.record.fields import INTEGER, REAL, layout, written_by
from chain_impact.kernel.record.friction import friction_changes_dtype, friction_dtype, friction_element_dtype
from chain_impact.kernel.record.given import (
    chain_dtype,
    contact_settings_dtype,
    drive_dtype,
    given_dtype,
    initial_dtype,
    inputs_dtype,
    site_dtype,
    slider_dtype,
    solver_dtype,
    stops_dtype,
    walls_dtype,
)
from chain_impact.kernel.record.prescribed_motion import channel_dtype, given_channel_dtype, wall_motion_dtype
from chain_impact.kernel.record.signals import knot_dtype, signal_dtype
from chain_impact.kernel.record.solver import (
    balance_dtype,
    budget_dtype,
    fault_dtype,
    implicit_dtype,
    scratch_dtype,
    search_dtype,
    statistics_dtype,
    step_dtype,
    trial_dtype,
)


@written_by(
    "observe.py",
    **dict.fromkeys(("transmitted", "slider_reaction", "slider_moment"), "transmitted_forces.py"),
)
def output_dtype(
    link_count: int,
    candidate_count: int,
    friction_element_count: int,
    transmitted_row_count: int,
    channel_count: int = 0,
    site_count: int = 0,
    signal_count: int = 0,
) -> np.dtype:
    """Return the layout of the outputs at the communication point.

    ``force``, ``penetration``, ``penetration_rate`` and ``impulse`` have an entry for each candidate. The
    entry of a joint's first stop has the values of both its stops: the moment on the joint's outer link [N·m,
    > 0 at joint_min], the angle beyond the stop [rad], the rate of this angle [rad/s], and the sum of the
    angular impulses [N·m·s]; the entry of the second stop is 0.
    """
    points = link_count + 1 + site_count
    return layout(
        ("point_position", REAL, (points, 2)),  # m, positions of the points 0…N, then of the sites
        ("point_velocity", REAL, (points, 2)),  # m/s, velocities of the points 0…N, then of the sites
        ("point_acceleration", REAL, (points, 2)),  # m/s², accelerations of the points 0…N, then of the sites
        ("angle", REAL, (link_count,)),  # rad, absolute angle of each link from +x
        ("angular_velocity", REAL, (link_count,)),  # rad/s, absolute angular velocity of each link
        ("angular_acceleration", REAL, (link_count,)),  # rad/s², absolute angular acceleration of each link
        # rad, angle of each link relative to the link before; entry 0: absolute angle of link 1
        ("joint_angle", REAL, (link_count,)),
        # rad/s, angular velocity of each link relative to the link before; entry 0: absolute, of link 1
        ("joint_angular_velocity", REAL, (link_count,)),
        ("slider_position", REAL),  # m, position of the base along the slider's line, 0 at the start
        ("slider_velocity", REAL),  # m/s, velocity of the base along the slider's line
        ("slider_acceleration", REAL),  # m/s², acceleration of the base along the slider's line
        # N, force of the slider's line on the carriage, > 0 to the left of the line's direction; set only if
        # the outputs of transmitted forces are requested
        ("slider_reaction", REAL),
        # N·m, moment of the slider's line on the carriage, anticlockwise; set as ``slider_reaction``
        ("slider_moment", REAL),
        # N, normal force of the wall on the point, ≥ 0; for joints' stops see ``combine_forces``
        ("force", REAL, (candidate_count,)),
        # m, penetration of each candidate; 0 without contact and at a rigid wall
        ("penetration", REAL, (candidate_count,)),
        # m/s, rate of the penetration, > 0 during compression; 0 where ``penetration`` is 0
        ("penetration_rate", REAL, (candidate_count,)),
        # N·s, normal impulse of the wall on the point since the run's start; for joints' stops see
        # ``combine_impulses``
        ("impulse", REAL, (candidate_count,)),
        ("kinetic", REAL),  # J, kinetic energy of links, armatures and carriage
        ("potential", REAL),  # J, potential energy of gravity, zero at the origin
        ("elastic", REAL),  # J, energy stored in contacts and in springs of passive drives
        # J, energy dissipated by contacts, dampers of passive drives and dry friction since the run's start
        ("dissipated", REAL),
        # J, energy supplied by inputs, powered drives and prescribed motions since the run's start
        ("supplied", REAL),
        ("total", REAL),  # J, sum of the kinetic, potential and elastic energy
        ("friction", friction_output_dtype(friction_element_count)),
        ("transmitted", transmitted_output_dtype(transmitted_row_count)),
        # m, position of each channel: base, walls and belts with prescribed motions
        ("channel", REAL, (channel_count,)),
        # value of each signal that drives an input or a motion, and the first and second derivative in time
        ("signal", REAL, (signal_count, 3)),
    )


STATE_OUTPUTS = (
    *("point_position", "point_velocity", "angle", "angular_velocity", "joint_angle"),
    *("joint_angular_velocity", "slider_position", "slider_velocity", "kinetic", "potential", "elastic"),
    *("dissipated", "supplied", "total", "channel", "signal"),
)
"""The outputs that ``observe_state`` (observe.py) fills; they contain no forces and no accelerations."""


def friction_output_dtype(friction_element_count: int) -> np.dtype:
    """Return the layout of the outputs of dry friction; an element is a candidate, a joint or the slider."""
    elements = (friction_element_count,)
    return layout(
        ("force", REAL, elements),  # N, friction force of the wall on a point, along t = (n_y, −n_x)
        ("impulse", REAL, elements),  # N·s, impulse of ``force`` since the run's start
        # 1: the contact of a candidate sticks; 0: the contact slides or has no friction, or does not exist
        ("sticking", REAL, elements),
        # entries 0…N−1: moment of dry friction on the outer link of each joint [N·m]; entry N: force of dry
        # friction on the slider [N]; later entries: 0
        ("drive_friction", REAL, elements),
        # entries 0…N−1: 1 if the joint sticks, else 0; entry N: the same for the slider; later entries: 0
        ("drive_sticking", REAL, elements),
        ("dissipated", REAL),  # J, energy that dry friction has dissipated since the run's start
    )


def transmitted_output_dtype(rows: int) -> np.dtype:
    """Return the layout of the outputs of transmitted forces: a row for each joint, then a row for each wall.

    Impulses, peaks and times of peaks are not used in the rows of walls.
    """
    return layout(
        # N, x and y of a force. Rows of joints: the force on the joint's outer link, by the link before, the
        # ground or the carriage. Rows of walls: the force of all points on the wall
        ("x", REAL, (rows,)),
        ("y", REAL, (rows,)),
        # N·m, rows of joints: moment on the joint's outer link; rows of walls: moment on the wall, about the
        # wall's point in `walls`, or about the origin for a wall of the box
        ("moment", REAL, (rows,)),
        # N·s, impulse of the joint's force since the run's start, x
        ("impulse_x", REAL, (rows,)),
        ("impulse_y", REAL, (rows,)),
        # N, largest magnitude of the force in the joint since the run's start
        ("peak", REAL, (rows,)),
        # s, time of ``peak``; the run's start as long as ``peak`` is 0
        ("peak_time", REAL, (rows,)),
    )


@written_by("transmitted_forces.py")
def transmitted_dtype(rows: int) -> np.dtype:
    """Return the layout of the data from which the outputs of transmitted forces follow.

    An array of shape (rows,) has the rows of ``transmitted_output_dtype``: the joints, then the walls.
    """
    return layout(
        ("run_start", REAL),  # s, time at which the run started
        # N·s, impulse of the input force at the tip from the run's start to the communication point
        ("tip_impulse", REAL, (2,)),
        # N·s, x and y of the momentum of each joint's outer link at the run's start; rows of walls are not
        # used
        ("start_x", REAL, (rows,)),
        ("start_y", REAL, (rows,)),
        # N², the largest squared force in each joint from the run's start to the last
        # ``raise_joint_force_peaks``
        ("peak_square", REAL, (rows,)),
        # s, time at which each joint had the squared force ``peak_square``
        ("peak_time", REAL, (rows,)),
        # N², the largest squared force in each joint that the search of the last step has found so far; the
        # search starts from a stored maximum (transmitted_forces.py)
        ("largest_square", REAL, (rows,)),
        # s, time of ``largest_square``, if this exceeds ``peak_square``
        ("largest_time", REAL, (rows,)),
        # N², ``largest_square`` after ``fill_joint_force_peaks`` (transmitted_forces.py) has last searched a
        # whole step
        ("searched_square", REAL, (rows,)),
        # values of `step.break_count` and of `step.end` [s] when ``fill_joint_force_peaks`` last searched a
        # whole step: the values tell which step this was
        ("searched_break_count", INTEGER),
        ("searched_end", REAL),
        # N, x and y of the joint forces at the last sampled time (transmitted_forces.py)
        ("x", REAL, (rows,)),
        ("y", REAL, (rows,)),
        # N², squares of the joint forces at three successive sampled times
        ("square_before", REAL, (rows,)),
        ("square_middle", REAL, (rows,)),
        ("square_after", REAL, (rows,)),
    )


def instance_dtype(*counts: int) -> np.dtype:
    """Return the layout of an instance; ``counts`` are the values of ``Counts`` in their order."""
    all_counts = Counts(*counts)
    (
        link_count,
        candidate_count,
        friction_element_count,
        transmitted_row_count,
        channel_count,
        site_count,
        signal_count,
        knot_count,
    ) = all_counts
    return layout(
        *((name, INTEGER) for name in COUNTS),
        ("skewed", INTEGER),  # 1: the centre of mass of some link may lie beside the link's line; else 0
        ("slides", INTEGER),  # 1: the base slides along a line, on a carriage; 0: the base is free or pinned
        # number of tangent instances that follow the record in memory (kernel/tangent/)
        ("tangent_count", INTEGER),
        ("chain", chain_dtype(link_count, site_count)),
        ("contact_settings", contact_settings_dtype()),
        ("stops", stops_dtype()),
        ("slider", slider_dtype()),
        ("drive", drive_dtype(link_count)),
        ("initial", initial_dtype(link_count)),
        ("solver", solver_dtype()),
        ("given", given_dtype(link_count)),
        ("inputs", inputs_dtype(link_count)),
        ("step", step_dtype(link_count, candidate_count)),
        ("trial", trial_dtype(link_count)),
        ("impact", impact_dtype()),
        ("latest", latest_dtype()),
        ("peaks", peaks_dtype()),
        ("statistics", statistics_dtype()),
        ("fault", fault_dtype()),
        ("budget", budget_dtype()),
        ("balance", balance_dtype()),
        ("scratch", scratch_dtype(link_count, site_count)),
        ("friction", friction_dtype(friction_element_count)),
        ("contacts", contacts_dtype(candidate_count)),
        ("candidate", candidate_dtype(candidate_count)),
        ("walls", walls_dtype(candidate_count)),
        ("law", law_dtype(candidate_count)),
        ("search", search_dtype(candidate_count)),
        ("contact_log", contact_log_dtype(candidate_count)),
        ("implicit", implicit_dtype(link_count, candidate_count, friction_element_count, site_count)),
        ("constraints", constraints_dtype(link_count, candidate_count, friction_element_count)),
        ("limited_forces", limited_forces_dtype(link_count, friction_element_count)),
        ("friction_element", friction_element_dtype(friction_element_count)),
        ("quadrature", quadrature_dtype(candidate_count, friction_element_count)),
        ("friction_changes", friction_changes_dtype(friction_element_count)),
        ("output", output_dtype(*all_counts[:-1])),  # outputs do not depend on the number of knots
        ("transmitted", transmitted_dtype(transmitted_row_count)),
        ("wall_motion", wall_motion_dtype(candidate_count)),
        ("given_channel", given_channel_dtype(channel_count)),
        ("channel", channel_dtype(channel_count)),
        ("site", site_dtype(link_count, site_count)),
        ("signal", signal_dtype(signal_count, knot_count)),
        ("knot", knot_dtype(knot_count)),
    )
