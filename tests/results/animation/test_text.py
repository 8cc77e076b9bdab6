"""Numbers as text."""

import pytest

from chain_impact.results.animation.text import force_text, rate_text


@pytest.mark.parametrize(
    ("force", "text"),
    [
        (12345.0, "12.3 kN"),
        (999.0, "999 N"),
        (0.5, "0.500 N"),
        (2.5e6, "2.50 MN"),
        (0.0, "0 N"),
        (841.4, "841 N"),
    ],
)
def test_forces_have_three_digits(force, text):
    assert force_text(force) == text


@pytest.mark.parametrize(
    ("rate", "text"),
    [
        (1.0, "real time"),
        (0.5, "2 × slower"),
        (4.0, "4 × faster"),
        (1 / 543, "540 × slower"),
        (1 / 6.94, "6.9 × slower"),
    ],
)
def test_rates_say_how_many_times_slower(rate, text):
    assert rate_text(rate) == text
