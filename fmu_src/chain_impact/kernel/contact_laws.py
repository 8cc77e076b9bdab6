"""The contact laws of the Hunt–Crossley family, and the registry that names them.

    F = K δⁿ (1 + λ δ̇/v₀),  F ≥ 0

K stiffness [N/mⁿ], δ penetration [m], δ̇ its rate [m/s], v₀ the approach speed at the onset of this contact
[m/s]. The laws differ only in the damping factor λ(e) of the prescribed restitution e; λ is found once for
a set of parameters, never inside the force.

Exact for any n, K, mass and v₀: the realised restitution e′ solves λ(1 + e′) = ln[(1+λ)/(1−λe′)], so
e′ = [1 + W₀(−(1+λ)e^{−(1+λ)})]/λ with Lambert's W (derived in docs/contact_laws.md).

To add a law, add a function with the decorator: its place in this file is its number in the FMU, so new
laws go to the end.
"""

import math

from chain_impact.kernel.jit import jit


class ContactLaw:
    """One entry of the registry.

    Attributes:
        id: its name in scene files and in the FMU.
        number: its number in the FMU's enumeration, from 1.
        title: authors, for tables.
        source: author, year, journal.
        formula: λ(e) as text.
        evidence: how the formula was checked; see docs/contact_laws.md.
        accurate_from, accurate_to: restitutions for which the rebound is within 5 % of the prescribed one.
        allows_zero: whether λ(0) is finite.
        impulsive: whether the walls are rigid: impulses in place of a force law (kernel/impulses.py).
        damping_factor: λ(e), compiled.
    """

    id: str
    number: int
    title: str
    source: str
    formula: str
    evidence: str
    accurate_from: float
    accurate_to: float
    allows_zero: bool
    impulsive: bool
    damping_factor: object

    def __init__(self, **entries: object) -> None:
        for name, value in entries.items():
            setattr(self, name, value)

    @property
    def restitution_range(self) -> str:
        """The restitutions that the law allows, as text."""
        return "0 ≤ e ≤ 1" if self.allows_zero else "0 < e ≤ 1"


CONTACT_LAWS: dict[str, ContactLaw] = {}


def contact_law(title, source, formula, *, accurate, evidence, allows_zero=True, impulsive=False):
    """Register the decorated λ(e) as the next contact law, under the function's name."""

    def register(function):
        CONTACT_LAWS[function.__name__] = ContactLaw(
            id=function.__name__,
            number=len(CONTACT_LAWS) + 1,
            title=title,
            source=source,
            formula=formula,
            evidence=evidence,
            accurate_from=accurate[0],
            accurate_to=accurate[1],
            allows_zero=allows_zero,
            impulsive=impulsive,
            damping_factor=jit(function),
        )
        return CONTACT_LAWS[function.__name__].damping_factor

    return register


@contact_law("Hertz", "Hertz 1881, J Reine Angew Math 92:156", "0", accurate=(1.0, 1.0), evidence="A")
def hertz(e):
    """Elastic: no dissipation, whatever e."""
    return 0.0 * e


@contact_law(
    "Hunt & Crossley",
    "Hunt & Crossley 1975, J Appl Mech 42:440",
    "3(1−e)/2",
    accurate=(0.785, 1.0),
    evidence="A",
)
def hunt_crossley(e):
    """For e near 1: energy lost along the elastic path."""
    return 1.5 * (1.0 - e)


@contact_law(
    "Herbert & McWhannell",
    "Herbert & McWhannell 1977, J Eng Ind 99:513",
    "6(1−e)/[(2e−1)²+3]",
    accurate=(0.66, 1.0),
    evidence="B",
)
def herbert_mcwhannell(e):
    """Impact of a gear pair, integrated over the contact."""
    return 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0)


@contact_law(
    "Lee & Wang",
    "Lee & Wang 1983, J Mech Transm Autom Des 105:534",
    "3(1−e)/4",
    accurate=(0.915, 1.0),
    evidence="B",
)
def lee_wang(e):
    """Half the damping of Hunt and Crossley: for e close to 1."""
    return 0.75 * (1.0 - e)


@contact_law(
    "Lankarani & Nikravesh",
    "Lankarani & Nikravesh 1990, J Mech Des 112:369",
    "3(1−e²)/4",
    accurate=(0.82, 1.0),
    evidence="B, recomputed",
)
def lankarani_nikravesh(e):
    """For e near 1: energy lost, from momentum balance, along the elastic path."""
    return 0.75 * (1.0 - e * e)


@contact_law(
    "Gonthier et al.",
    "Gonthier, McPhee, Lange & Piedbœuf 2004, Multibody Syst Dyn 11:209",
    "(1−e²)/e",
    accurate=(0.0, 1.0),
    evidence="A",
    allows_zero=False,
)
def gonthier(e):
    """Close for all e: the largest error of the realised restitution is 0.032."""
    return (1.0 - e * e) / e


@contact_law(
    "Zhang & Sharf",
    "Zhang & Sharf 2009, J Appl Mech 76:051002",
    "root of λ(1+e) = ln[(1+λ)/(1−λe)]",
    accurate=(0.0, 1.0),
    evidence="derived; after the paper",
    allows_zero=False,
)
def zhang_sharf(e):
    """Exact for all e: the realised restitution is the prescribed one."""
    if e >= 1.0:
        return 0.0
    u = 1.0 - e
    # Near e = 1 the root is a difference of nearly equal numbers; this series is exact to u⁵
    if u < 1e-3:
        return u * (1.5 + u * (1.5 + u * (1.35 + u * 1.2)))
    # With d = λe = 1 − e^{−s} the equation reads s − d(1 + 1/e) + ln(1 + d/e) = 0. It is well conditioned
    # in s, and not in d: below e ≈ 0.03 d is 1 to double precision. The left side is concave-then-rising
    # with one positive root; bisection is safe and runs once for a set of parameters.
    low, high = 1e-12, 2.0 + 2.0 / e
    while high - low > 4e-16 * high:
        s = 0.5 * (low + high)
        d = -math.expm1(-s)
        if s - d * (1.0 + 1.0 / e) + math.log1p(d / e) < 0.0:
            low = s
        else:
            high = s
    return -math.expm1(-0.5 * (low + high)) / e


@contact_law(
    "Zhiying & Qishao",
    "Zhiying & Qishao 2006, J Dyn Control 4:294",
    "¾(1−e²)e^{2(1−e)}",
    accurate=(0.335, 1.0),
    evidence="B",
)
def zhiying_qishao(e):
    """Lankarani and Nikravesh, corrected for lower e."""
    return 0.75 * (1.0 - e * e) * math.exp(2.0 * (1.0 - e))


@contact_law(
    "Ye, Li & Zhu",
    "Ye, Li & Zhu 2009, Earthq Eng Struct Dyn 38:1135",
    "8(1−e)/(5e)",
    accurate=(0.54, 1.0),
    evidence="A",
    allows_zero=False,
)
def ye(e):
    """Pounding of buildings; the formula that Flores et al. found too."""
    return 1.6 * (1.0 - e) / e


@contact_law(
    "Flores et al.",
    "Flores, Machado, Silva & Martins 2011, Multibody Syst Dyn 25:357",
    "8(1−e)/(5e)",
    accurate=(0.54, 1.0),
    evidence="A",
    allows_zero=False,
)
def flores(e):
    """For soft materials too: the damping grows without bound as e → 0."""
    return 1.6 * (1.0 - e) / e


@contact_law(
    "Gharib & Hurmuzlu",
    "Gharib & Hurmuzlu 2012, J Appl Mech 79:064506",
    "1/e",
    accurate=(0.0, 0.28),
    evidence="C",
    allows_zero=False,
)
def gharib_hurmuzlu(e):
    """For low e only: at e = 1 the realised restitution is 0.594."""
    return 1.0 / e


@contact_law(
    "Hu & Guo",
    "Hu & Guo 2015, Multibody Syst Dyn 35:131",
    "3(1−e)/(2e)",
    accurate=(0.405, 1.0),
    evidence="C",
    allows_zero=False,
)
def hu_guo(e):
    """Energy lost along the damped path."""
    return 1.5 * (1.0 - e) / e


@contact_law(
    "Carvalho & Martins",
    "Carvalho & Martins 2019, Mech Mach Theory 139:174",
    "(3/2)(1−e)(11−e)/(1+9e)",
    accurate=(0.21, 1.0),
    evidence="A",
)
def carvalho_martins(e):
    """A rational fit to the exact relation, in use down to e ≈ 0.2."""
    return 1.5 * (1.0 - e) * (11.0 - e) / (1.0 + 9.0 * e)


@contact_law(
    "Newton",
    "Newton 1687, Principia; Moreau 1988, CISM Courses 302:1",
    "none: u⁺ = −e u⁻",
    accurate=(0.0, 1.0),
    evidence="C",
    impulsive=True,
)
def newton_impact(e):
    """The rigid limit of all the others: impulses of no duration (kernel/impulses.py), so there is no λ."""
    return 0.0 * e


def _dispatch(functions):
    """One compiled function of (number, e) over all laws: the registry is the only list of them."""
    first, rest = functions[0], functions[1:]
    if not rest:
        return jit(lambda _number, e: first(e))
    others = _dispatch(rest)
    return jit(lambda number, e: first(e) if number == 1 else others(number - 1, e))


LAW_COUNT = len(CONTACT_LAWS)
NEWTON_IMPACT = CONTACT_LAWS["newton_impact"].number
damping_factor = _dispatch(tuple(law.damping_factor for law in CONTACT_LAWS.values()))


@jit
def elastic_force(contact, penetration):
    """K δⁿ [N] for a penetration δ > 0 [m]."""
    # the usual exponents without pow()
    if contact.exponent == 1.5:
        return contact.stiffness * penetration * math.sqrt(penetration)
    if contact.exponent == 1.0:
        return contact.stiffness * penetration
    return contact.stiffness * penetration**contact.exponent


@jit
def force_over_elastic(contact, rate, impact_speed):
    """1 + λ δ̇/v₀, the ratio of the contact force to its elastic part; at least 0, as walls do not pull."""
    return max(0.0, 1.0 + contact.damping_factor * rate / impact_speed)


@jit
def elastic_energy(contact, penetration):
    """K δⁿ⁺¹/(n+1) [J] for a penetration δ > 0 [m]."""
    return elastic_force(contact, penetration) * penetration / (contact.exponent + 1.0)


@jit
def elastic_depth(contact, mass, speed):
    """Penetration [m] at which a mass [kg] arriving at a speed [m/s] has given its energy to the spring."""
    # K δⁿ⁺¹/(n+1) = ½ m v²
    energy = 0.5 * mass * speed * speed
    return (energy * (contact.exponent + 1.0) / contact.stiffness) ** (1.0 / (contact.exponent + 1.0))
