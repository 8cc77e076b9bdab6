"""The units of the FMU's variables."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Unit:
    """What is measured in a unit, and the unit as powers of SI base units; None if these are not integers."""

    quantity: str
    powers: dict[str, int] | None


UNITS = {
    "1": Unit("Ratio", {}),
    "s": Unit("Time", {"s": 1}),
    "1/s": Unit("Frequency", {"s": -1}),
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
    "N.m": Unit("Torque", {"kg": 1, "m": 2, "s": -2}),
    "N.m/rad": Unit("RotationalStiffness", {"kg": 1, "m": 2, "s": -2, "rad": -1}),
    "N.m.s/rad": Unit("RotationalDamping", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
    "N/m^exponent": Unit("ContactStiffness", None),  # the exponent is a parameter, 3/2 for Hertz
    "J": Unit("Energy", {"kg": 1, "m": 2, "s": -2}),
}
"""Every unit of the FMU's variables."""
