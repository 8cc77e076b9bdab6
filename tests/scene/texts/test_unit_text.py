"""Units as texts."""

import pytest

from chain_impact.scene.texts.unit_text import (
    bracketed_unit,
    number_hint,
    power_hint,
    stiffness_unit,
    unit_text,
)
from chain_impact.variables.units import UNITS


@pytest.mark.parametrize(
    ("unit", "text"),
    {
        "N.m": "N·m",
        "N.m.s/rad": "N·m·s/rad",
        "kg.m2": "kg·m²",
        "rad/s2": "rad/s²",
        "N/m^1.5": "N/m^1.5",
        "N.m/(m/s)": "N·m/(m/s)",
        "1": "",
        None: "",
    }.items(),
)
def test_a_reader_sees_signs_of_products_and_powers(unit, text):
    assert unit_text(unit) == text
    assert bracketed_unit(unit) == (f" [{text}]" if text else "")


def test_no_unit_of_an_fmu_has_another_form():
    assert not any(mark in unit_text(unit) for unit in UNITS for mark in (".", "2"))


def test_an_exponent_of_one_is_not_written():
    assert (stiffness_unit("N/m", 1.0), stiffness_unit("N/m", 1.5)) == ("N/m", "N/m^1.5")


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("450 mm", "m", "0.45"),
        ("45cm", "m", "0.45"),
        ("70 %", "", "0.7"),
        ("-2.5e3 g", "kg", "-2.5"),
        ("3 kN·m", "N.m", "3000"),
        ("9.81 m/s^2", "m/s2", "9.81"),
        ("20 ms", "s", "0.02"),
        ("10 MN/m", "N/m^exponent", "10000000"),
        ("1e7N/m^1.5", "N/m^exponent", "10000000"),
    ],
)
def test_a_quantity_with_a_unit_is_told_as_a_number(text, unit, number):
    assert number_hint(text, [unit]).split(",")[0] == f"; write {number}"


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("10^7", "1e7"),
        ("2.5 * 10**-3", "2.5e-3"),
        ("3·10^+6", "3e6"),
        ("10", ""),
        ("2^7", ""),
        ("10^x", ""),
        ("2.*10^7", "2e7"),
        ("02*10^7", "2e7"),
        ("-10^7", "-1e7"),
    ],
)
def test_a_power_of_ten_is_told_as_a_number(text, number):
    assert power_hint(text) == (f"; write {number}" if number else "")


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("10 MN/mm", "N/m^exponent"),
        ("hard", "m"),
        ("3 feet", "m"),
        ("450 mm", "s"),
        ("1e3", "m"),
        ("50 %", "m"),
        ("2 m", ""),
    ],
)
def test_other_texts_have_no_hint(text, unit):
    assert number_hint(text, [unit]) == ""
