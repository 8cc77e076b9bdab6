"""The registry of contact laws: the properties of each, and the order of their numbers in the FMU."""

FAMILY_FORCE = "Kδⁿ (1 + λ δ̇/v₀)"
POWERS = {0.0: "", 0.25: "δ^¼ ", 0.5: "δ^½ "}
DAMPINGS = {0.0: "λ K/v₀", 0.5: "f √(K m)", 0.4: "f K^⅗ m^⅖ at 1 m/s"}


class ContactLaw:
    """One entry of the registry: F = max(0, K δⁿ + d δᵖ δ̇), or impulses.

    Attributes:
        id: its name in scene files and in the FMU.
        number: its number in the FMU's enumeration, from 1.
        title: authors, for tables.
        source: author, year, journal.
        formula: the factor f(e) as text; λ(e) of the Hunt–Crossley family.
        limits: its range of use, its limits and known flaws.
        evidence: how the formula was checked; see docs/contact_laws.md.
        accurate_from, accurate_to: restitutions for which the rebound is within 5 % of the prescribed one.
        allows_zero: whether f(0) is finite.
        exponent: the n for which it is defined; None for any.
        rate_exponent: p; None for p = n.
        mass_power: s of d = f K^(1−s) m^s, with the effective mass m; 0 for the family, where d = λ K/v₀.
        approach_only: whether the damping acts only during compression.
        impulsive: whether the walls are rigid: impulses instead of a force (kernel/events/impulses.py).
        damping_factor: f(e), a function of the kernel.
    """

    id: str
    number: int
    title: str
    source: str
    formula: str
    limits: str
    evidence: str
    accurate_from: float
    accurate_to: float
    allows_zero: bool
    exponent: float | None
    rate_exponent: float | None
    mass_power: float
    approach_only: bool
    impulsive: bool
    damping_factor: object

    def __init__(self, **entries: object) -> None:
        for name, value in entries.items():
            setattr(self, name, value)

    @property
    def restitution_range(self) -> str:
        """The restitutions that the law allows, as text."""
        return "0 ≤ e ≤ 1" if self.allows_zero else "0 < e ≤ 1"

    @property
    def in_family(self) -> bool:
        """Whether it belongs to the Hunt–Crossley family."""
        return self.rate_exponent is None and not self.impulsive

    @property
    def force(self) -> str:
        """The force as text, where it is not cut off at 0."""
        if self.impulsive:
            return "impulses"
        if self.rate_exponent is None:
            return FAMILY_FORCE
        rate = "max(0, δ̇)" if self.approach_only else "δ̇"
        spring = "Kδ" if self.exponent == 1.0 else "Kδ√δ"
        return f"{spring} + d {POWERS[self.rate_exponent]}{rate}"

    @property
    def damping(self) -> str:
        """How the damping d follows from f, as text."""
        return "–" if self.impulsive else DAMPINGS[self.mass_power]

    @property
    def continuous(self) -> bool:
        """Whether the force begins at 0, without a jump at the onset."""
        return self.rate_exponent != 0.0 and not self.impulsive

    def allows_exponent(self, exponent: float) -> bool:
        """Whether the law is defined for an exponent n."""
        return self.exponent is None or self.exponent == exponent


CONTACT_LAWS: dict[str, ContactLaw] = {}


def contact_law(
    title,
    source,
    formula,
    *,
    accurate,
    evidence,
    allows_zero=True,
    exponent=None,
    rate_exponent=None,
    mass_power=0.0,
    approach_only=False,
    impulsive=False,
):
    """Register the decorated f(e) as the next contact law, under the function's name.

    Its docstring states the limits of the law.
    """

    def register(function):
        CONTACT_LAWS[function.__name__] = ContactLaw(
            id=function.__name__,
            number=len(CONTACT_LAWS) + 1,
            title=title,
            source=source,
            formula=formula,
            limits=" ".join(function.__doc__.split()),
            evidence=evidence,
            accurate_from=accurate[0],
            accurate_to=accurate[1],
            allows_zero=allows_zero,
            exponent=exponent,
            rate_exponent=rate_exponent,
            mass_power=mass_power,
            approach_only=approach_only,
            impulsive=impulsive,
            damping_factor=function,
        )
        return CONTACT_LAWS[function.__name__].damping_factor

    return register
