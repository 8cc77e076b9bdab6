"""The properties of a contact law, and its force as text."""

from dataclasses import dataclass

FAMILY_FORCE = "Kδⁿ (1 + λ δ̇/v₀)"
# exponent of δ → the power of δ as text; powers with other exponents are written like δ^1.2
PENETRATION_POWERS = {0.0: "", 0.25: "δ^¼", 0.5: "δ^½", 1.0: "δ", 1.5: "δ√δ"}
DAMPING_FACTORS = {0.0: "λ K/v₀", 0.5: "f √(K m)", 0.4: "f K^⅗ m^⅖ at 1 m/s"}


@dataclass(frozen=True)
class ContactLaw:
    """One law in the registry, CONTACT_LAWS: a force F = max(0, K δⁿ + d δᵖ δ̇), or impulses.

    K is the stiffness, δ the penetration, d the damping; n and p are exponents. With ``approach_only`` the
    damping is 0 for δ̇ < 0.
    """

    id: str  # name in scene files and in the FMU
    number: int  # number in the FMU's enumeration of laws, from 1
    title: str  # authors of the law, as its title in tables
    source: str  # author, year and journal of the law's source
    formula: str  # the factor f(e) as text; for the Hunt–Crossley family this is λ(e)
    limits: str  # range of use, limits and known errors of the law
    # The quality of the source of the formula, as a letter or a word. A: an open source that cites the paper.
    # B: public code that follows a review. C: the standard literature. Derived or recomputed: the formula
    # also follows from an integration of a free impact.
    evidence: str
    accurate_from: float  # least restitution e from which on the realised restitution is within 5 % of e
    accurate_to: float  # largest restitution e up to which the realised restitution is within 5 % of e
    # function of the kernel that returns the factor f(e) of the damping for the prescribed restitution e
    damping_factor: object
    allows_zero: bool = True  # whether f(0) is finite, so that e = 0 is allowed
    exponent: float | None = None  # the exponent n for which the law is defined; None: any exponent
    rate_exponent: float | None = None  # exponent p of the penetration δ in the damping d δᵖ δ̇; None: p = n
    # exponent s in the damping d = f K^(1−s) m^s, with damping factor f, stiffness K and effective mass m.
    # The value 0 means that the damping has another formula, or that there is none: the Hunt–Crossley family
    # has d = f K/v₀ with the impact speed v₀, and a rigid wall has no damping.
    mass_power: float = 0.0
    # whether the damping acts only while the penetration grows
    approach_only: bool = False
    rigid: bool = False  # whether walls are rigid and act by impulses, see kernel/events/rigid_impacts.py

    @property
    def impulsive(self) -> bool:
        """Whether walls are rigid: another name of ``rigid``, for scripts that use it."""
        return self.rigid

    @property
    def restitution_range(self) -> str:
        """The restitutions that the law allows, as text for users."""
        return "0 ≤ e ≤ 1" if self.allows_zero else "0 < e ≤ 1"

    @property
    def in_family(self) -> bool:
        """Whether the law belongs to the Hunt–Crossley family, with the force K δⁿ (1 + λ δ̇/v₀)."""
        return self.rate_exponent is None and not self.rigid

    @property
    def force(self) -> str:
        """The formula of the force as text, without the cut at 0; "impulses" for a rigid wall."""
        if self.rigid:
            return "impulses"
        if self.rate_exponent is None:
            return FAMILY_FORCE
        rate_text = "max(0, δ̇)" if self.approach_only else "δ̇"
        spring = "δⁿ" if self.exponent is None else penetration_power(self.exponent)
        return f"K{spring} + " + " ".join(
            filter(None, ("d", penetration_power(self.rate_exponent), rate_text))
        )

    @property
    def damping(self) -> str:
        """The damping d in terms of the law's factor f (λ in the family), as text; "–" for a rigid wall."""
        power = self.mass_power
        return "–" if self.rigid else DAMPING_FACTORS.get(power, f"f K^{1.0 - power:g} m^{power:g}")

    @property
    def continuous(self) -> bool:
        """Whether the law has a force that begins at 0 at the onset, without a jump."""
        return self.rate_exponent != 0.0 and not self.rigid

    def allows_exponent(self, exponent: float) -> bool:
        """Return whether the law is defined for an exponent n."""
        return self.exponent is None or self.exponent == exponent


def penetration_power(exponent: float) -> str:
    """Return a power of the penetration as text, without blanks; "" for the power 0."""
    return PENETRATION_POWERS.get(exponent, f"δ^{exponent:g}")
