"""The integrals of a sine with a changing frequency and a rising amplitude, against adaptive quadrature."""

import math
from types import SimpleNamespace

import pytest
from scipy.integrate import quad

from chain_impact.kernel.chain.sines import sine_integral, smooth_ramp

# frequency [Hz], its rate [Hz/s], rise [s] and time [s]: steady, slow and fast changes, standstill on either
# side, rises with few and with many turns
CASES = [
    (3.0, 0.0, 0.0, 1.3),
    (3.0, 1e-9, 0.0, 1.3),
    (3.0, 0.4, 0.0, 1.3),
    (0.0, 5.0, 0.0, 1.1),
    (0.0, -5.0, 0.0, 0.2),
    (4.0, -5.0, 0.0, 0.79),
    (4.0, -5.0, 0.0, 2.1),
    (0.5, 0.0, 0.1, 0.08),
    (6.0, 0.0, 1.5, 1.2),
    (6.0, 30.0, 0.5, 0.4),
    (6.0, 0.4, 1.5, 0.1),
    (0.0, 8.0, 1.5, 1.4),
    (9.0, -8.0, 1.6, 1.55),
]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_integrals_of_a_sine_are_those_of_a_quadrature(case, order):
    frequency, rate, rise, time = case
    own = SimpleNamespace(phase=[0.7], frequency=[frequency], frequency_rate=[rate])
    d = SimpleNamespace(signal=own)

    def integrand(t):
        turns = t * (frequency + 0.5 * rate * t)
        return (
            (time - t) ** (order - 1)
            * (smooth_ramp(t / rise)[0] if rise else 1.0)
            * math.sin(0.7 + math.tau * turns)
        )

    expected, _ = quad(integrand, 0.0, time, epsabs=1e-14, epsrel=1e-13, limit=400)
    begin = sine_integral(d, 0, order, 0.0, rise) + (
        time * sine_integral(d, 0, 1, 0.0, rise) if order > 1 else 0.0
    )
    assert sine_integral(d, 0, order, time, rise) - begin == pytest.approx(expected, abs=2e-14)
