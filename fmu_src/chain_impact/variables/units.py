"""The units of the FMU's variables."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit: FMI's name of the quantity, and ``powers``: SI base unit or rad → its exponent in the unit.

    ``powers`` is None if the exponents are not fixed integers.
    """

    quantity: str
    powers: dict[str, int] | None


UNITS = {
    "1": Unit("Ratio", {}),
    "s": Unit("Time", {"s": 1}),
    "1/s": Unit("Frequency", {"s": -1}),
    "Hz": Unit("CyclicFrequency", {"s": -1}),
    "Hz/s": Unit("FrequencyRate", {"s": -2}),
    "m": Unit("Length", {"m": 1}),
    "m/s": Unit("Velocity", {"m": 1, "s": -1}),
    "m/s2": Unit("Acceleration", {"m": 1, "s": -2}),
    "rad": Unit("Angle", {"rad": 1}),
    "rad/s": Unit("AngularVelocity", {"rad": 1, "s": -1}),
    "rad/s2": Unit("AngularAcceleration", {"rad": 1, "s": -2}),
    "kg": Unit("Mass", {"kg": 1}),
    "kg.m2": Unit("MomentOfInertia", {"kg": 1, "m": 2}),
    "N.s": Unit("Impulse", {"kg": 1, "m": 1, "s": -1}),
    "N": Unit("Force", {"kg": 1, "m": 1, "s": -2}),
    "N.s/m": Unit("Damping", {"kg": 1, "s": -1}),
    "N/m": Unit("Stiffness", {"kg": 1, "s": -2}),
    "N.m.s": Unit("AngularImpulse", {"kg": 1, "m": 2, "s": -1}),
    "N.m": Unit("Torque", {"kg": 1, "m": 2, "s": -2}),
    "N.m/rad": Unit("RotationalStiffness", {"kg": 1, "m": 2, "s": -2, "rad": -1}),
    "N.m.s/rad": Unit("RotationalDamping", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
    # contact.exponent is a parameter, 3/2 for Hertz, so the unit has no fixed exponents of base units
    "N/m^exponent": Unit("ContactStiffness", None),
    "N.m/rad^exponent": Unit("StopStiffness", None),
    "J": Unit("Energy", {"kg": 1, "m": 2, "s": -2}),
}
"""Name of a unit in FMUs → the unit; ``unit_of`` also has the units of derivatives, which are quotients."""


def unit_of_derivative(unit: str, parameter: str) -> str:
    """Return the name of a derivative's unit: ``unit``, of the output, divided by the unit ``parameter``."""
    if parameter == "1":
        return unit
    return "1" if unit == parameter else f"{unit}/({parameter})"


def unit_of(name: str) -> Unit:
    """Return the unit with a name.

    Raises ValueError if the name is neither a key of ``UNITS`` nor a quotient of two keys.
    """
    if name in UNITS:
        return UNITS[name]
    numerator, _, denominator = name.removesuffix(")").partition("/(")
    if not {numerator, denominator} <= UNITS.keys():
        raise ValueError(f"unit {name}: must be a key of UNITS in variables/units.py, or a quotient of two")
    numerator_unit, denominator_unit = UNITS[numerator], UNITS[denominator]
    powers = None
    if numerator_unit.powers is not None and denominator_unit.powers is not None:
        bases = dict.fromkeys((*numerator_unit.powers, *denominator_unit.powers))
        powers = {
            base: numerator_unit.powers.get(base, 0) - denominator_unit.powers.get(base, 0) for base in bases
        }
        powers = {base: power for base, power in powers.items() if power}
    return Unit(f"{numerator_unit.quantity}Per{denominator_unit.quantity}", powers)


def sorted_units(names: set[str]) -> list[str]:
    """Return names of units in the order in which FMUs list them: keys of ``UNITS``, then sorted quotients.

    The name "", which stands for no unit, is left out.
    """
    return [*(name for name in UNITS if name in names), *sorted(names - UNITS.keys() - {""})]
