"""The entry points of the compiled kernel, as C functions on a pointer to the instance.

int32 initialize(instance*, double time)
int32 advance(instance*, double time)
int32 observe(instance*)
int64 trajectory(instance*, const double* times, int64 rows, output* out)
    int32 follow(instance*)
"""

from numba import carray, float64, int32, int64, types

from chain_impact.kernel.advance import advance, restart
from chain_impact.kernel.impacts import follow_to_now
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.jit import jit
from chain_impact.kernel.observe import observe
from chain_impact.kernel.status import OK

UNLIMITED = 1 << 62


@jit
def trajectory(d, times, out):
    """Advance to each of the times [s] in turn and fill one row of outputs for each.

    Returns:
        The number of rows filled: fewer than asked for after a fault, or when the log of finished contacts
        is about to overflow and has to be collected.
    """
    room = len(d.finished.point) - len(d.touch.active)
    for row in range(len(times)):
        if advance(d, times[row], room) != OK:
            return row
        observe(d, out[row])
    return len(times)


def entry_points(instance, output):
    """The C functions for the record types of an instance and its output: name → (signature, function)."""
    pointer, rows = types.CPointer(instance), types.CPointer(output)

    def initialize_entry(p, time):
        return initialize(carray(p, (1,))[0], time)

    def advance_entry(p, time):
        return advance(carray(p, (1,))[0], time, UNLIMITED)

    def observe_entry(p):
        d = carray(p, (1,))[0]
        if d.statistics.status == OK and d.inputs.changed and restart(d) != OK:
            d.inputs.changed = 1  # a parameter that goes with the others may yet be set before the next step
        observe(d, d.output)
        return d.statistics.status

    def follow_entry(p):
        follow_to_now(carray(p, (1,))[0])
        return 0

    def trajectory_entry(p, times, count, out):
        return trajectory(carray(p, (1,))[0], carray(times, (count,)), carray(out, (count,)))

    return {
        "initialize": (int32(pointer, float64), initialize_entry),
        "advance": (int32(pointer, float64), advance_entry),
        "observe": (int32(pointer), observe_entry),
        "follow": (int32(pointer), follow_entry),
        "trajectory": (int64(pointer, types.CPointer(float64), int64, rows), trajectory_entry),
    }
