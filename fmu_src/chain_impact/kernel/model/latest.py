"""The latest impacts, newest first, for the importer of an FMU: an active contact has its values so far.

Those of a stop are of its joint's angle: moments and rad.
"""

from chain_impact.kernel.model.geometry import lever

LATEST = 32  # how many are kept at most


def forget_impacts(d):
    """Clear the list, so that no contact is in it."""
    latest = d.latest
    for c in range(d.candidates):
        d.touch.number[c] = 0
    for row in range(len(latest.time)):
        latest.time[row], latest.end[row] = 0.0, 0.0
        latest.point[row], latest.wall[row] = -1, 0
        latest.speed[row], latest.separation_speed[row] = 0.0, 0.0
        latest.peak_force[row], latest.max_penetration[row], latest.impulse[row] = 0.0, 0.0, 0.0


def keep_impacts(d, count):
    """Let the list have so many impacts from now on."""
    d.latest.kept = count


def list_impact(d, c):
    """Insert the impact of candidate c, whose onset has just been counted, at the front of the list."""
    latest = d.latest
    for row in range(latest.kept - 1, 0, -1):
        before = row - 1
        latest.time[row], latest.end[row] = latest.time[before], latest.end[before]
        latest.point[row], latest.wall[row] = latest.point[before], latest.wall[before]
        latest.speed[row], latest.separation_speed[row] = (
            latest.speed[before],
            latest.separation_speed[before],
        )
        latest.peak_force[row], latest.impulse[row] = latest.peak_force[before], latest.impulse[before]
        latest.max_penetration[row] = latest.max_penetration[before]
    d.touch.number[c] = d.impact.count
    latest.time[0], latest.point[0] = d.impact.last_time, d.impact.last_point
    latest.wall[0], latest.speed[0] = d.impact.last_wall, d.impact.last_speed
    note_impact(d, c, d.impact.last_time, -d.touch.onset_speed[c], 0.0, 0.0, 0.0)


def note_impact(d, c, end, separation_speed, peak_force, max_penetration, impulse):
    """Store the values of the contact of candidate c at a time ``end`` [s], if it is still in the list.

    Args:
        d: the instance.
        c: the candidate.
        end: the time of these values [s].
        separation_speed: ġ at that time [m/s].
        peak_force: largest force so far [N].
        max_penetration: largest penetration so far [m].
        impulse: impulse so far [N·s].
    """
    latest, row = d.latest, d.impact.count - d.touch.number[c]
    if row < latest.kept:
        arm = lever(d, c)
        latest.end[row], latest.separation_speed[row] = end, separation_speed / arm
        latest.peak_force[row], latest.max_penetration[row] = peak_force * arm, max_penetration / arm
        latest.impulse[row] = impulse * arm
