"""The latest impacts, the newest first, as an importer sees them: one that lasts has its values so far."""

LATEST = 32  # how many are kept at most


def forget_impacts(d):
    """Begin without any."""
    latest = d.latest
    for row in range(len(latest.time)):
        latest.time[row], latest.end[row] = 0.0, 0.0
        latest.point[row], latest.wall[row] = -1, 0
        latest.speed[row], latest.separation_speed[row] = 0.0, 0.0
        latest.peak_force[row], latest.max_penetration[row], latest.impulse[row] = 0.0, 0.0, 0.0


def list_impact(d, c):
    """Put the impact of candidate c, whose onset was counted just now, before the others."""
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
    note_impact(d, c, d.impact.last_time, -d.impact.last_speed, 0.0, 0.0, 0.0)


def note_impact(d, c, end, separation_speed, peak_force, max_penetration, impulse):
    """Note what the contact of candidate c has come to at a time ``end`` [s], if it is still listed.

    Args:
        d: the instance.
        c: the candidate.
        end: when [s].
        separation_speed: ġ there [m/s].
        peak_force: so far [N].
        max_penetration: so far [m].
        impulse: so far [N·s].
    """
    latest, row = d.latest, d.impact.count - d.touch.number[c]
    if row < latest.kept:
        latest.end[row], latest.separation_speed[row] = end, separation_speed
        latest.peak_force[row], latest.max_penetration[row] = peak_force, max_penetration
        latest.impulse[row] = impulse
