"""Signals: functions of time by which the scene itself drives inputs and prescribed motions.

A signal is a sequence of polynomials. Each polynomial begins at a time t_k, called a knot, and is used until
the next knot. This part of the signal is a segment; `signal.segment` is the index of the knot at which the
present segment begins. In a signal of the form SINE a sine is added to the polynomial:

    u(t) = c₀ + x (c₁ + x (c₂ + …)) + r(s) a sin(ψ + 2π (f s + ½ ḟ s²)),   x = t − t_k,   s = t − start,

with the sine's start, its amplitude a, phase ψ, frequency f at the start and rate of change ḟ of the
frequency; r rises from 0 to 1, or is 1 from the start on. A step ends where a segment ends, and the next
segment begins with the next step (events/segments.py). So the step that ends at a jump of a signal uses the
value before the jump, and the next step the value after the jump.

If a signal is the velocity or the acceleration of a base, a wall or a belt, this module integrates the signal
to a position, so that position, velocity and acceleration always agree; the polynomials of a table are given
as those of the position. The integrals of a sine are in sines.py.
"""

import math

from chain_impact.kernel.chain.sines import TAU, sine_integral, sine_phase, smooth_ramp
from chain_impact.kernel.mathematics.angles import unit_vector
from chain_impact.kernel.record.constants import (
    CONSTANT,
    LINEAR,
    RAMP,
    SIGNAL_DEGREE,
    SINE,
    SMOOTH,
    STEPS,
    TABLE,
    TRAPEZOID,
)
from chain_impact.kernel.record.input_fields import CHANNEL, acts_in_drive

# number of knots of a sine, of a ramp and of a ramp with the shape of a trapezoid; a constant has one, steps
# and tables have any number
SINE_KNOTS, RAMP_KNOTS, TRAPEZOID_KNOTS = 3, 3, 5
RAMP_DEGREE, SPLINE_DEGREE = 5, 3
# the largest |first| and |second| derivative of ``smooth_ramp`` for x from 0 to 1
LARGEST_RAMP_SLOPE, LARGEST_RAMP_CURVATURE = 1.875, 5.7735027


def signal_at(d, j, time):
    """Return value, rate and second derivative of signal j at a ``time`` [s], by its segment in use.

    A signal that gives the velocity or acceleration of a channel has been integrated: its value is a
    position.
    """
    signal, knot, k, degree = d.signal, d.knot, d.signal.segment[j], d.signal.degree[j]
    x = time_since_knot(d, j, time)
    u, v, half_a = knot.powers[k, degree], 0.0 * x, 0.0 * x
    for p in range(1, degree + 1):
        half_a = half_a * x + v
        v = v * x + u
        u = u * x + knot.powers[k, degree - p]
    a = 2.0 * half_a
    if is_sine(d, j):
        su, sv, sa = sine_at(d, j, time)
        u, v, a = u + su, v + sv, a + sa
    return u + signal.begin[j] + signal.lap[j] * signal.gain[j], v, a


def has_signal(d, m):
    """Return whether a signal drives channel m, a prescribed motion."""
    for j in range(d.signal_count):
        if d.signal.input[j] == CHANNEL and d.signal.index[j] == m:
            return True
    return False


def time_since_knot(d, j, time):
    """Return the time x [s] from signal j's knot in use, in the present repetition of j, to ``time`` [s]."""
    return time - d.signal.lap[j] * d.signal.period[j] - d.knot.time[d.signal.segment[j]]


def sine_at(d, j, time):
    """Return value, rate and second derivative of the sine that is added to signal j, at a ``time`` [s].

    If the signal is integrated over time, once or twice, the results are value and derivatives of the
    integral of the sine.
    """
    signal, i = d.signal, d.signal.source[j]
    s = time - signal.start[i]
    rise = signal.rise[i] if signal.segment[j] == signal.first_knot[j] + 1 else 0.0
    rate, chirp = TAU * (signal.frequency[i] + signal.frequency_rate[i] * s), TAU * signal.frequency_rate[i]
    cosine, sine = unit_vector(sine_phase(d, i, s))
    a = signal.amplitude[i]
    u, v, w = a * sine, a * rate * cosine, a * (chirp * cosine - rate * rate * sine)
    if rise > 0.0:
        r, ramp_slope, ramp_curvature = smooth_ramp(s / rise)
        ramp_slope, ramp_curvature = ramp_slope / rise, ramp_curvature / (rise * rise)
        u, v, w = r * u, r * v + ramp_slope * u, r * w + 2.0 * ramp_slope * v + ramp_curvature * u
    for m in range(1, signal.integrals[j] + 1):
        u, v, w = a * sine_integral(d, i, m, s, rise), u, v
    return u, v, w


def signal_bounds(d, j):
    """Return upper bounds of the first and second |derivative| in time of signal j in the last step."""
    signal, knot, k = d.signal, d.knot, d.signal.segment[j]
    half = 0.5 * (d.step.end - d.step.start)
    x = time_since_knot(d, j, d.step.start + half)
    rate, curvature, power = 0.0 * x, 0.0 * x, 1.0
    for n in range(1, signal.degree[j] + 1):
        # c is coefficient n of the polynomial's Taylor series about the middle of the step: the n-th
        # derivative there, divided by n!
        c, weight = knot.powers[k, n] + 0.0 * x, 1.0 + 0.0 * x
        for p in range(n + 1, signal.degree[j] + 1):
            weight *= x * (p / (p - n))
            c += weight * knot.powers[k, p]
        rate += n * abs(c) * power
        if n > 1:
            curvature += n * (n - 1) * abs(c) * power / half
        power *= half
    if is_sine(d, j):
        i, amplitude = signal.source[j], abs(signal.amplitude[signal.source[j]])
        w, chirp = largest_frequency(d, j), TAU * abs(signal.frequency_rate[i])
        rises = signal.segment[j] == signal.first_knot[j] + 1 and signal.rise[i] > 0.0
        ramp_slope = LARGEST_RAMP_SLOPE / signal.rise[i] if rises else 0.0
        ramp_curvature = LARGEST_RAMP_CURVATURE / (signal.rise[i] * signal.rise[i]) if rises else 0.0
        if signal.integrals[j] == 0:
            rate += amplitude * (w + ramp_slope)
            curvature += amplitude * (w * w + chirp + 2.0 * ramp_slope * w + ramp_curvature)
        elif signal.integrals[j] == 1:
            rate, curvature = rate + amplitude, curvature + amplitude * (w + ramp_slope)
        else:
            _, v, _ = sine_at(d, j, d.step.start + half)
            rate, curvature = rate + abs(v) + half * amplitude, curvature + amplitude
    return rate, curvature


def is_sine(d, j):
    """Return whether signal j has the form SINE and has begun, so that the sine adds to the polynomial."""
    return d.signal.form[j] == SINE and d.signal.segment[j] > d.signal.first_knot[j]


def largest_frequency(d, j):
    """Return the largest absolute angular frequency [rad/s] of signal j, a sine, within the last step."""
    signal, i = d.signal, d.signal.source[j]
    f, chirp = signal.frequency[i], signal.frequency_rate[i]
    begin, end = f + chirp * (d.step.start - signal.start[i]), f + chirp * (d.step.end - signal.start[i])
    return TAU * max(abs(begin), abs(end))


def drives_base(d, j):
    """Return whether signal j drives a prescribed motion of the base."""
    return d.chain.base_moves and d.signal.input[j] == CHANNEL and d.signal.index[j] < 2


def acts_in_limited_drive(d, j):
    """Return whether signal j drives the motor, the target or the target velocity of a drive with a limit."""
    return acts_in_drive(d.signal.input[j]) and d.drive.limit[d.signal.index[j]] < math.inf


def drives_base_as_sine(d, j):
    """Return whether signal j is a sine that has begun, and drives a prescribed motion of the base."""
    return is_sine(d, j) and drives_base(d, j)


def signal_rate(d, j):
    """Return an angular frequency [rad/s], ≥ 0, that tells how fast signal j changes in the last step.

    - A sine that has begun: the largest angular frequency of the sine in the step.
    - A polynomial of a degree above 3, as of a smooth ramp: π divided by the duration of the segment, as if
      the segment were half a period of a cosine. Such a polynomial can rise and fall within a step, though
      its values and rates at both ends do not show this.
    - A polynomial of degree 3 or less: 0, because values and rates at both ends of a step determine it.
    """
    if is_sine(d, j):
        return largest_frequency(d, j)
    signal, k = d.signal, d.signal.segment[j]
    for p in range(SPLINE_DEGREE + 1, signal.degree[j] + 1):
        if d.knot.powers[k, p] != 0.0:
            return 0.5 * TAU / (segment_end(d, j) - signal.lap[j] * signal.period[j] - d.knot.time[k])
    return 0.0


def make_largest_rate(acts):
    """Return a function for the largest ``signal_rate`` [rad/s] of the signals for which ``acts`` is true.

    The returned function takes an instance; without such a signal, its result is 0. ``acts`` takes the
    instance and the index of a signal.
    """

    def rate(d):
        largest = 0.0
        for j in range(d.signal_count):
            if acts(d, j):
                largest = max(largest, signal_rate(d, j))
        return largest

    return rate


rate_of_signals = make_largest_rate(lambda _d, _j: True)
rate_in_limited_drives = make_largest_rate(acts_in_limited_drive)
rate_of_base = make_largest_rate(drives_base_as_sine)


def segment_end(d, j):
    """Return the end of the present segment of signal j [s]; ∞ if the segment has no end."""
    signal, k = d.signal, d.signal.segment[j]
    if k < signal.last_knot[j]:
        return signal.lap[j] * signal.period[j] + d.knot.time[k + 1]
    if signal.period[j] > 0.0:
        return (signal.lap[j] + 1) * signal.period[j] + d.knot.time[signal.first_knot[j]]
    return math.inf


def next_segment(d, j):
    """Begin the next segment of signal j or, after its last segment, the next repetition of its table."""
    signal = d.signal
    if signal.segment[j] < signal.last_knot[j]:
        signal.segment[j] += 1
    else:
        signal.segment[j] = signal.first_knot[j]
        signal.lap[j] += 1


def set_segment(d, j, k, lap):
    """Let signal j use the segment of knot k in repetition ``lap`` of its table, 0 for other signals."""
    d.signal.segment[j], d.signal.lap[j] = k, lap


def knot_count(form, shape):
    """Return the number of knots of a signal of a ``form``, and of a ``shape`` if it is a ramp.

    A constant has one knot. Signals of steps and tables have a knot for each given time; for these the result
    is the least number, 1.
    """
    if form == SINE:
        return SINE_KNOTS
    if form == RAMP:
        return TRAPEZOID_KNOTS if shape == TRAPEZOID else RAMP_KNOTS
    return 1


# ---- derivation of the polynomials from the scene's numbers -----------------------------------------------


def derive_signals(d, time):
    """Derive the polynomials of all signals from the given numbers, and begin the signals at ``time`` [s].

    If a signal gives a velocity or an acceleration of base, wall or belt, its polynomials are integrated, so
    that they give the position. The polynomials of a table are not derived: they are given, and already
    integrated.
    """
    signal = d.signal
    for j in range(d.signal_count):
        i, k = signal.source[j], signal.first_knot[j]
        signal.begin[j], signal.integrals[j] = 0.0, 0
        signal.degree[j] = signal.order[j] + (RAMP_DEGREE if signal.form[j] == RAMP else 0)
        if signal.form[j] == TABLE:
            signal.degree[j] = signal.order[j] + SPLINE_DEGREE
        if signal.form[j] == CONSTANT:
            set_constant_knot(d, k, time, signal.value[i])
        elif signal.form[j] == SINE:
            derive_sine(d, i, k)
        elif signal.form[j] == RAMP:
            derive_ramp(d, i, k, signal.shape[i])
        elif signal.form[j] == STEPS:
            for n in range(signal.last_knot[j] - k + 1):
                given = signal.first_knot[i] + n
                set_constant_knot(d, k + n, d.knot.given_time[given], d.knot.given_value[given])
        if signal.form[j] != TABLE:
            for _ in range(signal.order[j]):
                integrate_signal(d, j, time)
        begin_signal(d, j, time)
        if signal.order[j] > 0 and drives_base(d, j):
            signal.begin[j] = d.initial.position[signal.index[j]]


def begin_signal(d, j, time):
    """Let signal j begin at a ``time`` [s]: set the segment that contains this time, or else the first one.

    For a periodic table, the number of its repetition at this time is set, too; this number may be negative.
    """
    signal = d.signal
    signal.segment[j], signal.lap[j] = signal.first_knot[j], 0
    while (
        signal.period[j] > 0.0 and signal.lap[j] * signal.period[j] + d.knot.time[signal.first_knot[j]] > time
    ):
        signal.lap[j] -= 1
    while segment_end(d, j) <= time:
        next_segment(d, j)


def set_constant_knot(d, k, time, value):
    """Set knot k to a constant polynomial with the value ``value``, which begins at a ``time`` [s]."""
    d.knot.time[k] = time
    for p in range(1, SIGNAL_DEGREE + 1):
        d.knot.powers[k, p] = 0.0
    d.knot.powers[k, 0] = value


def derive_sine(d, i, k):
    """Set the three knots of a sine, from index k on; row i of `signal` has its given numbers.

    Their segments are the times before the sine's start, during its rise, and after the rise. Each
    polynomial is constant: the mean, to which ``sine_at`` is added from the start on. Before the start of a
    sine that does not rise, the constant is the value of the signal at the start.
    """
    signal = d.signal
    rises = signal.rise[i] > 0.0
    _, sine = unit_vector(signal.phase[i])
    mean_before = signal.mean[i] + (0.0 if rises else signal.amplitude[i] * sine)
    set_constant_knot(d, k, signal.start[i], mean_before)
    set_constant_knot(d, k + 1, signal.start[i], signal.mean[i])
    set_constant_knot(d, k + 2, signal.start[i] + signal.rise[i], signal.mean[i])


def derive_ramp(d, i, k, shape):
    """Set the knots of a ramp with a ``shape``, from knot k on; row i of `signal` has the ramp's numbers."""
    signal, powers = d.signal, d.knot.powers
    change, duration, start = signal.final[i] - signal.initial[i], signal.duration[i], signal.start[i]
    set_constant_knot(d, k, start, signal.initial[i])
    set_constant_knot(d, k + 1, start, signal.initial[i])
    speed = change / duration
    if shape == LINEAR:
        powers[k + 1, 1] = speed
    elif shape == SMOOTH:
        coefficient = speed / (duration * duration)
        powers[k + 1, 3], powers[k + 1, 4] = 10.0 * coefficient, -15.0 * coefficient / duration
        powers[k + 1, 5] = 6.0 * coefficient / (duration * duration)
    else:
        # a trapezoid has three phases of equal duration: uniform acceleration, uniform speed, uniform
        # deceleration
        coefficient = 2.25 * speed / duration
        powers[k + 1, 2] = coefficient
        set_constant_knot(d, k + 2, start + duration / 3.0, signal.initial[i] + 0.25 * change)
        set_constant_knot(d, k + 3, start + 2.0 * duration / 3.0, signal.initial[i] + 0.75 * change)
        powers[k + 2, 1], powers[k + 3, 1], powers[k + 3, 2] = 1.5 * speed, 1.5 * speed, -coefficient
        k += 2
    set_constant_knot(d, k + 2, start + duration, signal.final[i])


def integrate_signal(d, j, time):
    """Replace the polynomials of signal j by their integrals; the whole signal becomes 0 at a ``time`` [s].

    ``sine_at`` adds the integral of a sine; the polynomials' constants keep the sum continuous at knots.
    """
    signal, knot = d.signal, d.knot
    signal.integrals[j] += 1
    for k in range(signal.first_knot[j], signal.last_knot[j] + 1):
        for p in range(SIGNAL_DEGREE, 0, -1):
            knot.powers[k, p] = knot.powers[k, p - 1] / p
        knot.powers[k, 0] = 0.0
        if k > signal.first_knot[j]:
            signal.segment[j] = k - 1
            value_before, _, _ = signal_at(d, j, knot.time[k])
            signal.segment[j] = k
            value_after, _, _ = signal_at(d, j, knot.time[k])
            knot.powers[k, 0] = value_before - value_after
    begin_signal(d, j, time)
    u, _, _ = signal_at(d, j, time)
    for k in range(signal.first_knot[j], signal.last_knot[j] + 1):
        knot.powers[k, 0] -= u


def signals_are_valid(d):
    """Return whether all signals are valid.

    Times and coefficients of the knots must be finite, and the times must not decrease. If a sine is
    integrated, its frequency and the frequency's rate of change must not both be 0.
    """
    signal = d.signal
    for j in range(d.signal_count):
        i, total = signal.source[j], 0.0
        for k in range(signal.first_knot[j], signal.last_knot[j] + 1):
            if k > signal.first_knot[j] and not d.knot.time[k] >= d.knot.time[k - 1]:
                return False
            total += d.knot.time[k]
            for p in range(SIGNAL_DEGREE + 1):
                total += d.knot.powers[k, p]
        # sines.py has no integral of a sine that has the frequency 0 at all times: its formulas divide by the
        # frequency
        is_still = signal.form[j] == SINE and signal.frequency[i] == 0.0 and signal.frequency_rate[i] == 0.0
        if not math.isfinite(total) or (is_still and signal.order[j] > 0):
            return False
    return True
