"""The integrals over time of a sine whose frequency may change and whose amplitude may rise.

    I_m = m-fold integral of r(s) sin Φ(s),   Φ = ψ + 2π (f s + ½ ḟ s²),   ω = Φ′,   g = Φ″

s is the time since the start of the sine, and a prime is a derivative in s. Φ is the phase at s, ψ the phase
at the start, f the frequency at the start, and ḟ the rate of change of the frequency. The amplitude r is the
smooth ramp from 0 to 1, or constantly 1. E_n is an n-fold integral of e^{iΦ}. Integration by parts gives

    I_m = Im Σ_k c_k E_{m+k},   c_k = (−1)ᵏ (m+k−1 over k) r⁽ᵏ⁾,   k = 0…5
    E_{n+1} = (i E_{n−1} + ω E_n)/(n g),   E_0 = e^{iΦ}

with the binomial coefficient (m+k−1 over k) and the derivatives r⁽ᵏ⁾ of r. A constant r has only k = 0.

One solution of the recurrence for E_n falls with n: E_n = e^{iΦ} K_n/(iω)ⁿ. The ratios of its successive K_n
follow from a continued fraction, which is exact for g = 0 and loses no digits for small g:

    K_n/K_{n−1} = 1/(1 + i n y K_{n+1}/K_n),   y = g/ω²

Source: W. Gautschi 1967, SIAM Rev 9:24.

At a time s* the frequency may pass zero. There ω = 0, and near s* the fraction is not accurate: E_1 is then
computed as a Fresnel integral, its value C at s* plus a quadrature from s* to s. As long as ω has the sign
that it has at the start, the fraction gives the integral E_1 that is C at s*. After the change of this sign
the fraction gives another integral, which is −C at s*. The difference of both integrals is the solution of
the recurrence that begins with E_0 = 0, E_1 = 2C. This solution is added after the change of sign, so that
E_1 does not jump.

If Φ changes little during the rise of r, the terms c_k E_{m+k} are large and cancel; I_m is then computed by
quadrature.
"""

import math

from chain_impact.kernel.mathematics.angles import unit_vector

TAU = 2.0 * math.pi
SMOOTH_RAMP_DEGREE = 5  # degree of the polynomial of the smooth ramp from 0 to 1, see ``smooth_ramp``
# The continued fraction is used up to |y| = NEAR_TURNING_POINT, y = g/ω², with the angular frequency ω and
# its rate g. Where |y| is larger, the phase is within 4 rad, 1/(2 NEAR_TURNING_POINT), of its value at the
# time of frequency 0.
NEAR_TURNING_POINT = 0.125
# The largest number of levels of the continued fraction is FRACTION_DEPTH + FRACTION_DEPTH_GROWTH |y| without
# a rise, and FRACTION_DEPTH_IN_RISE + FRACTION_DEPTH_GROWTH |y| in a rise, with y = g/ω², the angular
# frequency ω and its rate g. With fewer levels the 2-fold integral E_2 of e^{iΦ} would lose digits, and in a
# rise E_7.
FRACTION_DEPTH, FRACTION_DEPTH_IN_RISE, FRACTION_DEPTH_GROWTH = 12, 30, 900.0
# levels are added to the continued fraction until its relative error is at most FRACTION_ERROR, or their
# number is the largest
FRACTION_ERROR = 1e-17
# LARGEST_TURN: if the phase turns by at most LARGEST_TURN [rad] in a rise, the integral is computed by
# quadrature; if the phase turns more, the terms c_k E_{m+k} hardly cancel, and no quadrature is needed.
# PANEL_TURN: the largest turn [rad] in one panel of a quadrature.
LARGEST_TURN, PANEL_TURN = 24.0, 6.0
# the nodes and weights of Gauss–Legendre quadrature on [0, 1]
# fmt: off
GAUSS_NODES = (0.009219682876640375, 0.04794137181476257, 0.11504866290284765, 0.2063410228566913,
    0.3160842505009099, 0.43738329574426554, 0.5626167042557345, 0.6839157494990901,
    0.7936589771433087, 0.8849513370971523, 0.9520586281852375, 0.9907803171233597)
GAUSS_WEIGHTS = (0.023587668193255914, 0.05346966299765921, 0.08003916427167311, 0.10158371336153296,
    0.1167462682691774, 0.12457352290670139, 0.12457352290670139, 0.1167462682691774,
    0.10158371336153296, 0.08003916427167311, 0.05346966299765921, 0.023587668193255914)
# fmt: on


def smooth_ramp(x):
    """Return the ramp 10 x³ − 15 x⁴ + 6 x⁵, from 0 at x = 0 to 1 at x = 1, and its first two derivatives."""
    y = 1.0 - x
    return x * x * x * (10.0 + x * (6.0 * x - 15.0)), 30.0 * x * x * y * y, 60.0 * x * y * (1.0 - 2.0 * x)


def sine_phase(d, i, s):
    """Return the phase Φ [rad] of the sine in row i of ``d.signal``, a time s [s] after its start."""
    signal = d.signal
    return signal.phase[i] + TAU * s * (signal.frequency[i] + 0.5 * signal.frequency_rate[i] * s)


def sine_integral(d, i, m, s, rise):
    """Return the m-fold integral I_m of the sine in row i of ``d.signal``, a time s [s] after its start.

    I_m is that of r sin Φ, without the signal's amplitude. ``rise`` is the duration [s] of the rise r if s
    lies within the rise, else 0.
    """
    begin, g = TAU * d.signal.frequency[i], TAU * d.signal.frequency_rate[i]
    omega = begin + g * s
    if rise > 0.0 and max(abs(begin), abs(begin + g * rise)) * rise <= LARGEST_TURN:
        return integral_by_quadrature(d, i, m, s, rise)
    cosine, sine = unit_vector(sine_phase(d, i, s))
    begins_up = begin > 0.0 or (begin == 0.0 and g > 0.0)
    if not abs(g) <= NEAR_TURNING_POINT * omega * omega:
        middle, u, v = integral_at_standstill(d, i, begins_up)
        u, v = add_fresnel_integral(middle, omega / g, g, u, v)
        return integral_by_recurrence(m, (cosine, sine, u, v), (omega, g), s, rise)
    u, v = integral_by_fraction(m, (omega, g), s, rise)
    total = sine * u + cosine * v
    if begins_up != (omega > 0.0):
        _, u, v = integral_at_standstill(d, i, begins_up)
        total += integral_by_recurrence(m, (0.0 * u, 0.0 * v, 2.0 * u, 2.0 * v), (omega, g), s, rise)
    return total


def integral_by_fraction(m, rates, s, rise):
    """Return the real and the imaginary part of Σ_k c_k K_{m+k}/(iω)^{m+k}, from continued fractions.

    The imaginary part of this sum times e^{iΦ} is the m-fold integral of a sine. ``rates`` are ω, the angular
    frequency, and g, the rate at which ω changes. The docstring of this module defines the functions K and
    the coefficients c.
    """
    omega, g = rates
    y = g / (omega * omega)
    last_level = m + 1 + (SMOOTH_RAMP_DEGREE if rise > 0.0 else 0)
    level_count, error = last_level, 1.0
    most_levels = (FRACTION_DEPTH_IN_RISE if rise > 0.0 else FRACTION_DEPTH) + FRACTION_DEPTH_GROWTH * abs(y)
    while error > FRACTION_ERROR and level_count < most_levels:
        level_count += 1
        # the error of a level K_n/K_{n−1} of the fraction is at most n |y| times the error of the next level
        # K_{n+1}/K_n; the module's docstring has the symbols
        error *= level_count * abs(y)
    ratio_u, ratio_v, u, v = 1.0 + 0.0 * y, 0.0 * y, 0.0 * y, 0.0 * y
    for k in range(level_count):
        n = level_count - k
        a, b = 1.0 - n * y * ratio_v, n * y * ratio_u
        squared_modulus = a * a + b * b
        ratio_u, ratio_v = a / squared_modulus, -b / squared_modulus
        u, v = (u * ratio_v + v * ratio_u) / omega, (v * ratio_v - u * ratio_u) / omega
        if m < n <= last_level:
            u += rise_coefficient(m, n - m - 1, s, rise)
    return u, v


def integral_by_recurrence(m, first, rates, s, rise):
    """Return the m-fold integral Im Σ_k c_k E_{m+k} of a sine, from the recurrence for the integrals E_n.

    ``first`` contains the real and imaginary parts of E_0 and E_1; ``rates`` are ω [rad/s] at the time ``s``
    and the rate g [rad/s²] of ω. ``s`` and ``rise`` are those of ``rise_coefficient``.
    """
    u, v, next_u, next_v = first
    omega, g = rates
    total = rise_coefficient(m, 0, s, rise) * next_v if m == 1 else 0.0 * next_v
    for n in range(1, m + (SMOOTH_RAMP_DEGREE if rise > 0.0 else 0)):
        after_u, after_v = (omega * next_u - v) / (n * g), (omega * next_v + u) / (n * g)
        u, v, next_u, next_v = next_u, next_v, after_u, after_v
        if n + 1 >= m:
            total += rise_coefficient(m, n + 1 - m, s, rise) * next_v
    return total


def rise_coefficient(m, k, s, rise):
    """Return the coefficient c_k of the m-fold integral of a sine, a time s [s] after its start.

    c_k contains the k-th derivative of the smooth ramp of duration ``rise`` [s]. With ``rise`` = 0 the sine
    has its full amplitude from its start, and only c_0 = 1 is used.
    """
    if not rise > 0.0:
        return 1.0 + 0.0 * s
    x = s / rise
    r, slope, curvature = smooth_ramp(x)
    if k == 1:
        r = slope
    elif k == 2:
        r = curvature
    elif k == 3:
        r = 60.0 - 360.0 * x * (1.0 - x)
    elif k == 4:
        r = 720.0 * x - 360.0
    elif k == 5:
        r = 720.0 + 0.0 * x
    for n in range(1, k + 1):
        r *= -(m + n - 1) / (n * rise)
    return r


def integral_at_standstill(d, i, begins_up):
    """Return three numbers: the phase Φ(s*) [rad], and real and imaginary part of C, the value of E_1 at s*.

    s* is the time at which the frequency is zero. E_1 is an integral of e^{iΦ}, ω the rate of Φ, and g the
    rate of ω.

    C = ∓½ √(2π/|g|) e^{i(Φ(s*) + π/4)} [s] for g > 0, and ±½ √(2π/|g|) e^{i(Φ(s*) − π/4)} for g < 0; the
    upper sign is for ω > 0 at the start, the lower sign for ω < 0. ``begins_up`` tells whether ω > 0 at the
    start or, if ω = 0 at the start, after the start.
    """
    signal = d.signal
    rate = signal.frequency_rate[i]
    middle = signal.phase[i] - 0.5 * TAU * signal.frequency[i] * signal.frequency[i] / rate
    sign = 1.0 if rate > 0.0 else -1.0
    amplitude = (-0.5 if begins_up else 0.5) * sign / math.sqrt(abs(rate))
    cosine, sine = unit_vector(middle + sign * 0.25 * math.pi)
    return middle, amplitude * cosine, amplitude * sine


def add_fresnel_integral(middle, duration, g, u, v):
    """Add to u and v the real and imaginary part of ∫ e^{i(Φ* + ½ g t²)} dt from t = 0 to ``duration`` [s].

    ``middle`` is the phase Φ* [rad] at the time s* of frequency zero, ``duration`` the time since s*, and
    ``g`` the rate of the angular frequency [rad/s²]. Returns the new u and v.
    """
    for n in range(len(GAUSS_NODES)):
        t = duration * GAUSS_NODES[n]
        cosine, sine = unit_vector(middle + 0.5 * g * t * t)
        u += GAUSS_WEIGHTS[n] * duration * cosine
        v += GAUSS_WEIGHTS[n] * duration * sine
    return u, v


def integral_by_quadrature(d, i, m, s, rise):
    """Return I_m, the m-fold integral of r sin Φ, at the time s [s] since the start of the sine; m is 1 or 2.

    r is the amplitude that rises, Φ the phase. I_m = ∫ (s − t)^{m−1} r(t) sin Φ(t) dt from t = 0 to t = s, by
    quadrature. At s the amplitude r still rises; its rise lasts ``rise`` [s].
    """
    begin = TAU * d.signal.frequency[i]
    # `sine_integral` calls this function only for a turn up to LARGEST_TURN, which bounds the number of
    # panels
    turn = min(LARGEST_TURN, max(abs(begin), abs(begin + TAU * d.signal.frequency_rate[i] * s)) * abs(s))
    panels = 1
    while panels * PANEL_TURN < turn:
        panels += 1
    total = 0.0 * s
    for panel in range(panels):
        for n in range(len(GAUSS_NODES)):
            t = s * ((panel + GAUSS_NODES[n]) / panels)
            r, _, _ = smooth_ramp(t / rise)
            _, sine = unit_vector(sine_phase(d, i, t))
            for _ in range(1, m):
                r *= s - t
            total += GAUSS_WEIGHTS[n] / panels * s * r * sine
    return total
