"""Files of contact laws."""

LAW = "import math\n\n\ndef mine(penetration, stiffness, exponent):\n    return {}\n"
SINH = LAW.format("stiffness * math.sinh(penetration) ** exponent")
