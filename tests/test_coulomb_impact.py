"""The closed forms of an impact with friction, against the integration of its differential equations."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.coulomb_impact import Strike, rigid, stiff_limit
from tests.reference import exact_damping_factor

HYPOTHESES = ("newton", "poisson", "stronge")
ACCURATE = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "max_step": 0.3}
MINIMUM = 1e-3  # m/s, the least v₀


def drawn(seed):
    """A strike with a random inverse inertia and a random direction."""
    rng = np.random.default_rng(seed)
    nn, tt = rng.uniform(0.3, 4.0, 2)
    nt = rng.uniform(-0.95, 0.95) * np.sqrt(nn * tt)
    friction = rng.uniform(0.0, 1.5)
    sliding = rng.uniform(-3.0, 3.0) if seed % 5 else 0.0
    static = friction * rng.uniform(1.0, 1.5)
    return Strike(nn, nt, tt, 10 ** rng.uniform(-1.0, 0.5), sliding, friction, static)


STRIKES = [drawn(seed) for seed in range(20)]
# slip that pushes the point into the wall: W_nn < µ |W_nt|
JAMMED = Strike(1.0, 1.3, 2.0, 0.1, 3.0, 1.2)


def ratio_of(strike, sign):
    """F_t/F_n of slip with a sign, or of a point at v_t = 0."""
    if sign != 0.0:
        return -strike.friction * sign
    held = -strike.nt / strike.tt
    return held if strike.sticks else np.copysign(strike.friction, held)


def integrated(strike, damping):
    """ġ, v_t and the impulses at the end, by integration over time of δ̈ = −(W_nn + c W_nt) F.

    Neither the stiffness nor the exponent takes part in the result: both are 1. y = (δ, ġ, v_t, p, p_t).
    """
    latched, sign = max(strike.approach, MINIMUM), np.sign(strike.sliding)
    time, y = 0.0, np.array([0.0, -strike.approach, strike.sliding, 0.0, 0.0])
    while True:
        ratio = ratio_of(strike, sign)

        def rate(_, y, ratio=ratio, latched=latched):
            force = y[0] * (1.0 - damping * y[1] / latched)
            return [-y[1], *(force * strike.inverse_inertia @ [1.0, ratio]), force, force * ratio]

        events = falling(
            lambda _, y: y[0], lambda _, y, s=sign: s * y[2], lambda _, y, v=latched: 2 * v + y[1]
        )
        done = solve_ivp(rate, (time, 1e6), y, events=events if sign else events[::2], **ACCURATE)
        time, y = done.t[-1], done.y[:, -1]
        if len(done.t_events[0]):
            return y[1:]
        if len(done.t_events[-1]):
            latched *= 2.0
        else:
            sign = 0.0


def integrated_hypothesis(strike, restitution, hypothesis):
    """ġ, v_t and the impulses at the end, by integration over the normal impulse; y = (ġ, v_t, p_t, work)."""
    sign, impulse, turn = np.sign(strike.sliding), 0.0, None
    y = np.array([-strike.approach, strike.sliding, 0.0, 0.0])
    while True:
        ratio = ratio_of(strike, sign)

        def rate(_, y, ratio=ratio):
            return [*(strike.inverse_inertia @ [1.0, ratio]), ratio, y[0]]

        def rest(p, y, turn=turn):
            if turn is None:
                return -y[0]
            return {
                "newton": restitution * strike.approach - y[0],
                "poisson": (1.0 + restitution) * turn[0] - p,
                "stronge": (1.0 - restitution**2) * turn[1] - y[3],
            }[hypothesis]

        events = falling(rest, lambda _, y, s=sign: s * y[1])
        done = solve_ivp(rate, (impulse, 1e6), y, events=events if sign else events[:1], **ACCURATE)
        impulse, y = done.t[-1], done.y[:, -1]
        if not len(done.t_events[0]):
            sign = 0.0
        elif turn is None:
            turn = (impulse, y[3])
        else:
            return np.array([y[0], y[1], impulse, y[2]])


def falling(*functions):
    """Events that end an integration where a function falls through 0."""
    for function in functions:
        function.terminal, function.direction = True, -1
    return functions


def numbers(departure):
    return [departure.separation, departure.sliding, departure.normal, departure.tangential]


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("e", [0.2, 0.8, 1.0])
def test_the_limit_of_the_force_laws_is_that_of_the_equations(e):
    damping = exact_damping_factor(e)
    for strike in (*STRIKES, JAMMED):
        exact = integrated(strike, damping)
        np.testing.assert_allclose(numbers(stiff_limit(strike, damping)), exact, rtol=1e-10, atol=1e-10)


def test_the_strikes_have_every_sequence_of_phases():
    found = {stiff_limit(strike, 0.5).phases for strike in STRIKES}
    assert found == {("slip",), ("slip", "stick"), ("slip", "reverse"), ("stick",), ("reverse",)}
    # and slip may halt before the compression ends, or after it
    halts = {rigid(s, 0.5, "poisson").phases == rigid(s, 1e-9, "poisson").phases for s in STRIKES}
    assert halts == {True, False}


@pytest.mark.parametrize("hypothesis", HYPOTHESES)
def test_a_hypothesis_is_integrated_alike(hypothesis):
    for strike in (*STRIKES, JAMMED):
        exact = integrated_hypothesis(strike, 0.6, hypothesis)
        found = numbers(rigid(strike, 0.6, hypothesis))
        np.testing.assert_allclose(found, exact, rtol=1e-10, atol=1e-10)


def test_momentum_and_energy_agree():
    """u⁺ − u⁻ = W p; and the energy is also ½ (u⁺ − u⁻)·W⁻¹(u⁺ + u⁻)."""
    for strike in (*STRIKES, JAMMED):
        departures = [stiff_limit(strike, 0.7), *(rigid(strike, 0.4, name) for name in HYPOTHESES)]
        for departure in departures:
            before = np.array([-strike.approach, strike.sliding])
            after = np.array([departure.separation, departure.sliding])
            impulse = np.array([departure.normal, departure.tangential])
            np.testing.assert_allclose(after - before, strike.inverse_inertia @ impulse, atol=1e-13)
            lost = -0.5 * (after - before) @ np.linalg.solve(strike.inverse_inertia, after + before)
            assert departure.dissipated == pytest.approx(lost, abs=1e-12)


def test_all_agree_where_slip_never_halts():
    """And without friction, where e is that of the law, exactly."""
    e = 0.3
    damping = exact_damping_factor(e)
    steady = [strike for strike in STRIKES if stiff_limit(strike, damping).phases in (("slip",), ("stick",))]
    smooth = [dataclasses.replace(s, friction=0.0, static_friction=0.0) for s in STRIKES]
    assert len(steady) > 5
    for strike in (*steady, *smooth):
        limit = numbers(stiff_limit(strike, damping))
        assert limit[0] == pytest.approx(e * strike.approach, rel=1e-12)
        for hypothesis in HYPOTHESES:
            np.testing.assert_allclose(numbers(rigid(strike, e, hypothesis)), limit, rtol=1e-12, atol=1e-13)


def test_an_elastic_law_is_stronges_hypothesis():
    """With λ = 0 the work that compression stores is given back, in whatever phases of friction."""
    for strike in (*STRIKES, JAMMED):
        np.testing.assert_allclose(
            numbers(stiff_limit(strike, 0.0, minimum_speed=1e3)),
            numbers(rigid(strike, 1.0, "stronge")),
            rtol=1e-12,
            atol=1e-13,
        )


@pytest.mark.full("takes long")
def test_newtons_hypothesis_makes_energy_and_no_other():
    """In 400 random impacts with friction."""
    strikes, damping = [drawn(seed) for seed in range(400)], exact_damping_factor(0.9)
    assert min(rigid(strike, 0.9, "newton").dissipated for strike in strikes) < -1.0
    assert min(rigid(strike, 0.9, "poisson").dissipated for strike in strikes) > 0.0
    assert min(rigid(strike, 0.9, "stronge").dissipated for strike in strikes) > 0.0
    assert min(stiff_limit(strike, damping).dissipated for strike in strikes) > 0.0
