"""The kernel's model as C functions, for peer solvers that take function pointers.

The functions are compiled and linked as the kernel is, and use the same record. So peers evaluate the same
machine code as our solver, and the kernel begins and ends their contacts, and latches their impact speeds.
The state of functions named ``plain_`` is that of the kernel without the energies, u and the time, which do
not act on the motion; the state of those of CVODE, named ``cvode_``, has the dissipated energy, too.

    int32 PREFIX_start(instance*, double* y)                      initialize; the state at 0 s
    int32 PREFIX_stop(instance*, double t, const double* y)       set the state at t, to be observed
    void  plain_rate(double t, const double* y, double* rate, instance*)
    void  plain_least(double t, const double* y, double* value, instance*)
    int32 plain_switch(instance*, double* clock, double* y, int32* changes)
    void  plain_look(double* y, double* extremes, instance*)
    int32 plain_steps(instance*, double dt, int64 count, int32 euler, double* y, int32* changes,
                      double* limits)
    int32 cvode_rate(instance*, const double* y, double* rate)
    int32 cvode_roots(instance*, int32 careful, const double* y, double* value)
    int32 cvode_happen(instance*, double time, const double* y, const int32* changes)
    int32 cvode_look(instance*, const double* y, double* extremes)
    int32 cvode_weights(instance*, int32 careful, const double* y, double* weight)
"""

from __future__ import annotations

import ctypes
import hashlib
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
from numba import float64, int32, int64, types, void

from benchmarks import common
from chain_impact.compilation import compilers, prebuilt
from chain_impact.compilation.cache import get_or_make
from chain_impact.compilation.collecting import collect_only
from chain_impact.compilation.entry_points import Entries
from chain_impact.compilation.functions import compiled_function
from chain_impact.compilation.lower import lowered_code
from chain_impact.compilation.record_type import INSTANCE, vector
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.equations import mechanical_energy, rate_from_state, stored_energy
from chain_impact.kernel.events.event_exclusion import RELATCH_RATIO
from chain_impact.kernel.events.handlers import apply_events
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.ode.last_step import reset_step
from chain_impact.kernel.record.constants import CONTACT_ENDS, NO_EVENT, ONSET, RELATCH
from chain_impact.system import HOST

REALS, COUNTS = types.CPointer(float64), types.CPointer(int32)
# numbers of components, at the end of the kernel's state, that ``plain_`` and ``cvode_`` functions lack
PLAIN, CVODE = 4, 3
AT_ZERO = 1e-12  # [s] distance from zero in time at which a candidate has an event
# [m] added to event functions, so that a contact that has just begun or ended has a clearance other than 0:
# peers need a change of sign between the ends of a step
CLEAR = 1e-13
HOP = 0.2  # [1] first step of a flight · g / separation speed, so that a low flight is not skipped
# [1] first step of a contact · latched speed / expected penetration; this step is small, because the force δⁿ
# is flat at the onset
FIRST_STEP = 0.09
POLISH = 1e-7  # [s] largest correction of a solver's root
# [1] allowed error of a careful CVODE's positions in a contact, divided by the static penetration
POSITION_ERROR = 1e-2
# [1] height above the wall at which a contact of a careful CVODE ends, divided by the static penetration
MARGIN = 5e-2


@compiled_function
def rate_at(d, y, out):
    """Set ``out`` to the rate f(y) of the components of ``y``."""
    d.statistics.rhs_evaluations += 1
    rate_from_state(d, y, d.scratch.stage[0])
    for j in range(len(y)):
        out[j] = d.scratch.stage[0, j]


@compiled_function
def happen(d, time, y, changes):
    """Let events take effect.

    Args:
        d: the instance.
        time: time of the events [s].
        y: state at this time.
        changes: for each candidate the sign of the change in clearance, then for each candidate −1 if its
            contact latches again; 0 without an event.
    """
    d.step.end = time
    for j in range(len(y)):
        d.step.state_end[j] = y[j]
    for c in range(d.candidate_count):
        kind = RELATCH if changes[d.candidate_count + c] < 0 else NO_EVENT
        if d.contacts.active[c] and changes[c] > 0:
            kind = CONTACT_ENDS
        elif not d.contacts.active[c] and changes[c] < 0:
            kind = ONSET
        d.contacts.event[c] = kind
    apply_events(d)


def start_and_stop(prefix: str, left_out: int) -> Entries:
    """Return two functions: one sets the state at 0 s, the other sets a state at a time, to be observed."""

    def start(d, y):
        status = initialize(d, 0.0)
        for j in range(len(d.step.state) - left_out):
            y[j] = d.step.state[j]
        return status

    def stop(d, time, y):
        size = len(d.step.state) - left_out
        for j in range(len(d.step.state)):
            d.scratch.state[j] = y[j] if j < size else 0.0
        reset_step(d, time, d.scratch.state)
        return 0

    return {
        f"{prefix}_start": (int32(INSTANCE, REALS), start),
        f"{prefix}_stop": (int32(INSTANCE, float64, REALS), stop),
    }


# --- for solvers that stop where one event function falls through zero ------------------------------------


def rate(_t, y, out, d):
    """Set ``out`` to the rate f(y)."""
    rate_at(d, vector(y, len(d.step.state) - PLAIN), out)


@compiled_function
def least_event(d, y):
    """Return the smallest event function plus CLEAR, and its rate (0 if the event is a new latch)."""
    lowest, slope = np.inf, 0.0
    locate_points(d, y)
    for c in range(d.candidate_count):
        gap, gap_rate = clearance_and_rate(d, c)
        sign = -1.0 if d.contacts.active[c] else 1.0
        if sign * gap < lowest:
            lowest, slope = sign * gap, sign * gap_rate
        latch_margin = RELATCH_RATIO * d.contacts.latched_speed[c] + gap_rate
        if d.contacts.active[c] and latch_margin < lowest:
            lowest, slope = latch_margin, 0.0
    return lowest + CLEAR, slope


def least(_t, y, out, d):
    """Set ``out[0]`` to the smallest event function."""
    out[0], _ = least_event(d, vector(y, len(d.step.state) - PLAIN))


def switch(d, clock, values, changes):
    """Let the event at clock[0] [s] take effect, and propose the next step in clock[1] [s].

    A solver may find the root with a coarse tolerance in time: a step of Euler's method then leads from the
    time of the solver to the root. Returns the number of active contacts.
    """
    y = vector(values, len(d.step.state) - PLAIN)
    value, slope = least_event(d, y)
    if slope < 0.0 and abs(value) < -slope * POLISH:
        dt = -value / slope
        rate_from_state(d, y, d.scratch.stage[0])
        for j in range(len(y)):
            y[j] += dt * d.scratch.stage[0, j]
        clock[0] += dt
    hop = np.inf
    locate_points(d, y)
    for c in range(d.candidate_count):
        gap, gap_rate = clearance_and_rate(d, c)
        active = d.contacts.active[c]
        sign = -1.0 if active else 1.0
        falls = sign * gap_rate < 0.0 and sign * gap <= -sign * gap_rate * AT_ZERO + 1e-15
        changes[c] = (1 if active else -1) if falls else 0
        is_fast = active and -gap_rate >= RELATCH_RATIO * d.contacts.latched_speed[c] * (1.0 - 1e-9)
        changes[d.candidate_count + c] = -1 if is_fast and not falls else 0
        if falls:
            hop = min(hop, abs(gap_rate) * HOP / 9.81)
    d.step.next_size = clock[1]
    happen(d, clock[0], y, changes)
    if d.contacts.active_count == 0:
        clock[1] = min(clock[1], hop)
        return 0
    clock[1] = d.step.next_size
    for c in range(d.candidate_count):
        if changes[c] < 0 and d.contacts.active[c]:
            clock[1] = min(
                clock[1], FIRST_STEP * d.contacts.expected_penetration[c] / d.contacts.latched_speed[c]
            )
    return d.contacts.active_count


# --- for stability.py: the energy and depth of a state, and fixed steps -----------------------------------


@compiled_function
def energy_and_depths(d, y):
    """Return energy [J], largest penetration [m], and largest depth of points without a contact [m]."""
    locate_points(d, y)
    kinetic, potential = mechanical_energy(d, y)
    deepest, outside = 0.0, 0.0
    for c in range(d.candidate_count):
        gap, _ = clearance_and_rate(d, c)
        deepest = max(deepest, -gap)
        if not d.contacts.active[c]:
            outside = max(outside, -gap)
    return kinetic + potential + stored_energy(d, y), deepest, outside


@compiled_function
def raise_extremes(d, y, extremes):
    """Replace each of three numbers in ``extremes`` by that of ``energy_and_depths`` if this is larger."""
    energy, deepest, outside = energy_and_depths(d, y)
    # an energy that is no number makes ``extremes`` infinite, because max() could hide it
    extremes[0] = max(extremes[0], energy) if np.isfinite(energy) else np.inf
    extremes[1], extremes[2] = max(extremes[1], deepest), max(extremes[2], outside)


def look(y, extremes, d):
    """Raise the numbers in ``extremes`` to those of the state ``y`` (``raise_extremes``)."""
    raise_extremes(d, vector(y, len(d.step.state) - PLAIN), extremes)


def steps(d, dt, count, euler, values, changes, limits):  # noqa: PLR0917, compiled
    """Take fixed steps of semi-implicit Euler or of RK4; a contact begins and ends at the end of a step.

    Args:
        d: the instance.
        dt: step [s].
        count: the number of steps.
        euler: whether to take Euler's steps.
        values: state, changed in place.
        changes: room for ``happen``.
        limits: energy [J] and depth [m] at which the run stops. After the run, they are the highest energy
            and the largest depth in it or, if it has stopped, the last energy and the largest depth.

    Returns:
        The number of steps taken.
    """
    size, n = len(d.step.state) - PLAIN, d.link_count + 2
    y, z, stage = vector(values, size), d.scratch.state, d.scratch.stage
    highest, deepest = -np.inf, 0.0
    for step in range(count):
        energy, deep, _ = energy_and_depths(d, y)
        any_event = False
        for c in range(d.candidate_count):
            gap, gap_rate = clearance_and_rate(d, c)
            active = d.contacts.active[c]
            changes[c] = (1 if active else 0) if gap >= 0.0 else (0 if active else -1)
            is_fast = active and gap < 0.0 and -gap_rate > RELATCH_RATIO * d.contacts.latched_speed[c]
            changes[d.candidate_count + c] = -1 if is_fast else 0
            any_event = any_event or changes[c] != 0 or is_fast
        if any_event:
            happen(d, step * dt, y, changes)
            energy, _, _ = energy_and_depths(d, y)
        highest, deepest = max(highest, energy), max(deepest, deep)
        if not (energy <= limits[0] and deepest <= limits[1]):
            limits[0], limits[1] = energy, deepest
            return step
        rate_from_state(d, y, stage[0])
        if euler:
            for j in range(n):
                y[n + j] += dt * stage[0, n + j]
                y[j] += dt * y[n + j]
        else:
            for k in range(1, 4):
                part = dt if k == 3 else 0.5 * dt
                for j in range(size):
                    z[j] = y[j] + part * stage[k - 1, j]
                rate_from_state(d, z, stage[k])
            for j in range(size):
                y[j] += dt * (stage[0, j] + 2.0 * (stage[1, j] + stage[2, j]) + stage[3, j]) / 6.0
    limits[0], limits[1] = highest, deepest
    return count


# --- for CVODE, which has a root function for each event --------------------------------------------------


@compiled_function
def static_depth(d):
    """Return the penetration [m] under the weight of link 1."""
    weight = abs(d.chain.gravity[1]) * d.chain.mass[0]
    return (weight / d.law.stiffness[0]) ** (1.0 / d.law.exponent[0])


def cvode_rate(d, y, out):
    """Set ``out`` to the rate f(y); return 0, which tells CVODE that the call has succeeded."""
    rate_at(d, vector(y, len(d.step.state) - CVODE), out)
    return 0


def cvode_happen(d, time, y, changes):
    """Let events take effect (``happen``); return 0."""
    happen(d, time, vector(y, len(d.step.state) - CVODE), changes)
    return 0


def cvode_roots(d, careful, y, value):
    """Set each candidate's clearance, and for an active one the speed of a new latch minus its speed.

    CVODE's solution jumps by a part of its tolerance when it is re-initialized. So a point that leaves slowly
    would arrive and leave again, up to a million times, unless the contact ends a margin above the wall.
    There is no force at this height. Return 0.
    """
    margin = MARGIN * static_depth(d) if careful else 0.0
    locate_points(d, vector(y, len(d.step.state) - CVODE))
    for c in range(d.candidate_count):
        gap, gap_rate = clearance_and_rate(d, c)
        active = d.contacts.active[c]
        value[c] = gap - margin if active else gap
        # δ̇ = −ġ
        value[d.candidate_count + c] = (
            RELATCH_RATIO * d.contacts.latched_speed[c] + gap_rate if active else 1.0
        )
    return 0


def cvode_look(d, y, extremes):
    """Raise the numbers in ``extremes`` to those of the state ``y`` (``raise_extremes``); return 0."""
    raise_extremes(d, vector(y, len(d.step.state) - CVODE), extremes)
    return 0


def cvode_weights(d, careful, y, weight):
    """Set ``weight`` to 1 divided by the allowed error of each component; return 0.

    The usual allowed error is tolerance × (|y| + scale) with the kernel's scale. A careful CVODE allows for
    positions tolerance × scale, and during a contact at most POSITION_ERROR × the static penetration.
    """
    n, tolerance = d.link_count, d.solver.tolerance
    position = tolerance * d.chain.longest_link
    if careful and d.contacts.active_count > 0:
        position = min(position, POSITION_ERROR * static_depth(d))
    for j in range(2 * n + 5):
        if j < n + 2:
            allowed_error = position if j < 2 else position / d.chain.longest_link
            if not careful:
                allowed_error += tolerance * abs(y[j])
        else:
            scale = d.chain.longest_link if j < n + 4 else 1.0 if j < 2 * n + 4 else d.chain.energy_scale
            allowed_error = tolerance * (scale + abs(y[j]))
        weight[j] = 1.0 / allowed_error
    return 0


# --- the library --------------------------------------------------------------------------------------------


def entry_points() -> Entries:
    """Return the C functions."""
    solver, roots = void(float64, REALS, REALS, INSTANCE), int32(INSTANCE, int32, REALS, REALS)
    functions: Entries = start_and_stop("plain", PLAIN) | start_and_stop("cvode", CVODE)
    return functions | {
        "plain_rate": (solver, rate),
        "plain_least": (solver, least),
        "plain_switch": (int32(INSTANCE, REALS, REALS, COUNTS), switch),
        "plain_look": (void(REALS, REALS, INSTANCE), look),
        "plain_steps": (int32(INSTANCE, float64, int64, int32, REALS, COUNTS, REALS), steps),
        "cvode_rate": (int32(INSTANCE, REALS, REALS), cvode_rate),
        "cvode_roots": (roots, cvode_roots),
        "cvode_happen": (int32(INSTANCE, float64, REALS, COUNTS), cvode_happen),
        "cvode_look": (int32(INSTANCE, REALS, REALS), cvode_look),
        "cvode_weights": (roots, cvode_weights),
    }


def lower(file: str) -> None:
    """Write the C functions to a file in LLVM's language; this changes how the process compiles."""
    collect_only(any_python=False, guarded=True)
    Path(file).write_text(lowered_code(entry_points()), encoding="utf-8")


def digest(*sources: Path) -> str:
    """Return hexadecimal digits that change with the contents of files."""
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()[:12]


def built(links: int) -> Path:
    """Return the library for a number of links, compiled if it is not cached."""
    source, scope = Path(__file__), prebuilt.exact_scope(links)
    name = f"{source.stem}-{digest(source)}"
    program = "from benchmarks import kernel_model; "

    def write(file: Path) -> None:
        lower_file = f"{program}kernel_model.lower({str(file)!r})"
        subprocess.run([sys.executable, "-c", lower_file], cwd=common.ROOT, check=True)

    return get_or_make(
        f"{name}-{scope or 'any'}.so", lambda file: link(get_or_make(f"{name}.ll", write), scope, file)
    )


def link(lowered_file: Path, links: compilers.KernelScope, library: Path) -> None:
    """Build a library as for the kernel, without the C interface of FMUs."""
    functions = library.with_name("functions.o")
    compilers.compile_part(lowered_file.read_text(), functions, HOST, compilers.KERNEL, links)
    compilers.prepare_zig(HOST)
    registers = compilers.INTERFACE / "common" / "registers.c"
    compilers.link_library(HOST, library, functions, registers, *compilers.write_stubs(library, None))


@cache
def load(links: int) -> ctypes.CDLL:
    """Return the library of the ``plain_`` functions, compiled if it is not cached."""
    model = ctypes.CDLL(str(built(links)))
    pointer, double = ctypes.c_void_p, ctypes.c_double
    model.plain_start.argtypes = [pointer] * 2
    model.plain_rate.argtypes = model.plain_least.argtypes = [double, *[pointer] * 3]
    model.plain_rate.restype = model.plain_least.restype = model.plain_look.restype = None
    model.plain_switch.argtypes = [pointer] * 4
    model.plain_look.argtypes = [pointer] * 3
    model.plain_steps.argtypes = [pointer, double, ctypes.c_int64, ctypes.c_int32, *[pointer] * 3]
    model.plain_stop.argtypes = [pointer, double, pointer]
    return model
