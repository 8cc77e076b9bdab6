"""Units of variables and of derivatives: their powers of base units agree with their names."""

import re
from collections import Counter

import pytest

from chain_impact.variables.units import UNITS, sorted_units, unit_of, unit_of_derivative

# derived units in kg, m, s
DERIVED = {"N": {"kg": 1, "m": 1, "s": -2}, "J": {"kg": 1, "m": 2, "s": -2}, "Hz": {"s": -1}, "1": {}}
PLAIN = [name for name, unit in UNITS.items() if unit.powers is not None]


def powers_of(name):
    """Return the powers of base units in a name such as ``N.m.s/rad``."""
    total = Counter()
    numerator, _, denominator = name.partition("/")
    for part, sign in ((numerator, 1), (denominator, -1)):
        for factor in filter(None, part.split(".")):
            base, power = re.fullmatch(r"([A-Za-z1]+?)(\d?)", factor).groups()
            for base_unit, count in DERIVED.get(base, {base: 1}).items():
                total[base_unit] += sign * count * int(power or 1)
    return {base: power for base, power in total.items() if power}


def test_a_unit_has_the_powers_that_its_name_says():
    powers = {name: {base: n for base, n in UNITS[name].powers.items() if n} for name in PLAIN}
    assert powers == {name: powers_of(name) for name in PLAIN}
    assert [name for name in UNITS if name not in PLAIN] == ["N/m^exponent", "N.m/rad^exponent"]


def test_a_quotient_is_written_as_one():
    pairs = [("m", "kg"), ("N.m", "m/s"), ("m", "1"), ("m", "m"), ("1", "1")]  # 1: a number without a unit
    assert [unit_of_derivative(*pair) for pair in pairs] == ["m/(kg)", "N.m/(m/s)", "m", "1", "1"]


@pytest.mark.parametrize(
    ("dividend", "divisor"), [("m/s", "kg"), ("N.m", "m/s"), ("J", "N.m.s/rad"), ("1", "kg")]
)
def test_the_powers_of_a_quotient_are_differences(dividend, divisor):
    powers = Counter(UNITS[dividend].powers)
    powers.subtract(UNITS[divisor].powers)
    quotient_unit = unit_of(f"{dividend}/({divisor})")
    assert quotient_unit.powers == {base: power for base, power in powers.items() if power}
    assert quotient_unit.quantity == f"{UNITS[dividend].quantity}Per{UNITS[divisor].quantity}"
    assert unit_of(dividend) is UNITS[dividend]
    assert unit_of("m/(N/m^exponent)").powers is None


def test_units_are_listed_in_one_order():
    assert sorted_units({"", "m/(kg)", "m", "J", "J/(kg)", "1"}) == ["1", "m", "J", "J/(kg)", "m/(kg)"]


def test_an_unknown_unit_is_named():
    with pytest.raises(ValueError, match="unit furlong: must be a key of UNITS"):
        unit_of("furlong")
