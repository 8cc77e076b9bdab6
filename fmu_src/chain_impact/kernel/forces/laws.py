"""The contact laws: the force of each law, its properties and its number in the FMU.

    F = max(0, K δⁿ + d δᵖ δ̇)

K is the stiffness [N/mⁿ], δ the penetration [m], δ̇ its rate [m/s]. The damping d of a contact is computed at
the onset from the factor f(e): each law defines this function of the prescribed restitution e.
There are three kinds of laws:

- The laws of the Hunt–Crossley family have p = n, f = λ and d = λ K/v₀, so that F = K δⁿ (1 + λ δ̇/v₀), with
  the approach speed v₀ at the onset [m/s]. The realised restitution e′ depends on λ alone: e′ solves
  λ(1 + e′) = ln[(1+λ)/(1−λe′)], so e′ = [1 + W₀(−(1+λ)e^{−(1+λ)})]/λ with Lambert's W.
- The other laws with a force have p ≠ n, and each of them holds for one exponent n. Their damping is
  d = f K^(1−s) m^s, with an exponent s of the law and the effective mass m of the chain at the contact [kg].
- The law of rigid walls has impulses instead of a force, so it has no d (events/rigid_impacts.py).

The relations are derived in docs/contact_laws.md. The number of a law is its position in this file, counted
from 1. The FMU uses these numbers, so a new law goes to the end.
"""

import math

from chain_impact.kernel.combinators import dispatch_by_number
from chain_impact.kernel.forces.contact_law import ContactLaw
from chain_impact.kernel.forces.viscoelastic import viscoelastic_factor
from chain_impact.kernel.mathematics.exponentials import exp, expm1
from chain_impact.kernel.mathematics.logarithms import log, log1p

CONTACT_LAWS: dict[str, ContactLaw] = {}


def register_law(title, source, formula, accurate, evidence, **properties):
    """Return a decorator that registers a function f(e) as the next contact law, with the function's name.

    The docstring of f becomes the limits of the law. ``title`` has the authors of the law; if ``source``
    begins with a year, the authors are put before the year. ``accurate`` is the pair of the law's
    ``accurate_from`` and ``accurate_to``. The other arguments are fields of ``ContactLaw``.
    """

    def register(function):
        CONTACT_LAWS[function.__name__] = ContactLaw(
            id=function.__name__,
            number=len(CONTACT_LAWS) + 1,
            title=title,
            source=f"{title} {source}" if source[0].isdigit() else source,
            formula=formula,
            limits=" ".join(function.__doc__.split()),
            evidence=evidence,
            accurate_from=accurate[0],
            accurate_to=accurate[1],
            damping_factor=function,
            **properties,
        )
        return function

    return register


@register_law("Hertz", "1881, J Reine Angew Math 92:156", "0", (1.0, 1.0), "A")
def hertz(e):
    """Elastic: no dissipation, whatever e."""
    return 0.0 * e


@register_law("Hunt & Crossley", "1975, J Appl Mech 42:440", "3(1−e)/2", (0.785, 1.0), "A")
def hunt_crossley(e):
    """For e near 1: the energy loss assumes elastic motion."""
    return 1.5 * (1.0 - e)


@register_law("Herbert & McWhannell", "1977, J Eng Ind 99:513", "6(1−e)/[(2e−1)²+3]", (0.66, 1.0), "B")
def herbert_mcwhannell(e):
    """From the motion in an impact of gears."""
    return 6.0 * (1.0 - e) / ((2.0 * e - 1.0) * (2.0 * e - 1.0) + 3.0)


@register_law("Lee & Wang", "1983, J Mech Transm Autom Des 105:534", "3(1−e)/4", (0.915, 1.0), "B")
def lee_wang(e):
    """Half the damping of Hunt and Crossley: for e close to 1."""
    return 0.75 * (1.0 - e)


@register_law("Lankarani & Nikravesh", "1990, J Mech Des 112:369", "3(1−e²)/4", (0.82, 1.0), "B, recomputed")
def lankarani_nikravesh(e):
    """For e near 1: energy loss by momentum balance; elastic motion assumed."""
    return 0.75 * (1.0 - e * e)


@register_law(
    "Gonthier et al.",
    "Gonthier, McPhee, Lange & Piedbœuf 2004, Multibody Syst Dyn 11:209",
    "(1−e²)/e",
    (0.0, 1.0),
    "A",
    allows_zero=False,
)
def gonthier(e):
    """Close for all e > 0: the largest error of the realised restitution is 0.032."""
    return (1.0 - e * e) / e


@register_law(
    "Zhang & Sharf",
    "2009, J Appl Mech 76:051002",
    "root of λ(1+e) = ln[(1+λ)/(1−λe)]",
    (0.0, 1.0),
    "derived; after the paper",
    allows_zero=False,
)
def zhang_sharf(e):
    """Exact for one contact on its own, for all e > 0."""
    if e >= 1.0:
        return 0.0
    u = 1.0 - e
    # near e = 1 the root is a difference of nearly equal numbers; this series in u = 1 − e has an error ∝ u⁵
    if u < 1e-3:
        return u * (1.5 + u * (1.5 + u * (1.35 + u * 1.2)))
    # With d = λe = 1 − e^{−s}, the equation for the factor λ reads s − d(1 + 1/e) + ln(1 + d/e) = 0. The root
    # s is found, not d, because below e ≈ 0.025 d is 1 in double precision. From 0 at s = 0 the left side
    # falls, and then rises through its only positive root; from this root on it is convex in s. So Newton's
    # method decreases monotonically from a start above the root; this start is above by at most 11 %.
    s, before = u * (1.0 / e + 0.58), math.inf
    while s < before:
        d = -expm1(-s)
        value = s - d * (1.0 + 1.0 / e) + log1p(d / e)
        slope = 1.0 - (1.0 - d) * (1.0 + 1.0 / e - 1.0 / (e + d))
        before, s = s, s - value / slope
    return -expm1(-s) / e


@register_law("Zhiying & Qishao", "2006, J Dyn Control 4:294", "¾(1−e²)e^{2(1−e)}", (0.335, 1.0), "B")
def zhiying_qishao(e):
    """Lankarani and Nikravesh, corrected for lower e."""
    return 0.75 * (1.0 - e * e) * exp(2.0 * (1.0 - e))


@register_law(
    "Ye, Li & Zhu", "2009, Earthq Eng Struct Dyn 38:1135", "8(1−e)/(5e)", (0.54, 1.0), "A", allows_zero=False
)
def ye(e):
    """For pounding of buildings; Flores et al. have the same formula."""
    return 1.6 * (1.0 - e) / e


@register_law(
    "Flores et al.",
    "Flores, Machado, Silva & Martins 2011, Multibody Syst Dyn 25:357",
    "8(1−e)/(5e)",
    (0.54, 1.0),
    "A",
    allows_zero=False,
)
def flores(e):
    """Meant for soft materials, too, but inaccurate for low e."""
    return 1.6 * (1.0 - e) / e


@register_law("Gharib & Hurmuzlu", "2012, J Appl Mech 79:064506", "1/e", (0.0, 0.28), "C", allows_zero=False)
def gharib_hurmuzlu(e):
    """For low e only: at e = 1 the realised restitution is 0.594."""
    return 1.0 / e


@register_law(
    "Hu & Guo", "2015, Multibody Syst Dyn 35:131", "3(1−e)/(2e)", (0.405, 1.0), "C", allows_zero=False
)
def hu_guo(e):
    """The energy loss assumes damped motion."""
    return 1.5 * (1.0 - e) / e


@register_law(
    "Carvalho & Martins", "2019, Mech Mach Theory 139:174", "(3/2)(1−e)(11−e)/(1+9e)", (0.21, 1.0), "A"
)
def carvalho_martins(e):
    """A rational fit to the exact relation, usable down to e ≈ 0.2."""
    return 1.5 * (1.0 - e) * (11.0 - e) / (1.0 + 9.0 * e)


@register_law(
    "Kelvin–Voigt",
    "Anagnostopoulos 1988, Earthq Eng Struct Dyn 16:443; 2004, 33:897",
    "2ζ, ζ = −ln e/√(π²+ln²e)",
    (0.611, 1.0),
    "C, recomputed",
    exponent=1.0,
    rate_exponent=0.0,
    mass_power=0.5,
    allows_zero=False,
)
def kelvin_voigt(e):
    """Spring and dashpot: the force jumps at the onset. The formula of f holds for a contact that can pull.

    Here the force is cut off at 0, so the realised restitution is higher: e^(1 − (2/π) arctan(−ln e/π)).
    """
    return _logarithmic_damping(2.0, e)


@register_law(
    "Tsuji, Tanaka & Ishida",
    "1992, Powder Technol 71:239; α after Antypov & Elliott 2011, EPL 94:50004",
    "α = −√5 ln e/√(π²+ln²e)",
    (0.611, 1.0),
    "C, recomputed",
    exponent=1.5,
    rate_exponent=0.25,
    mass_power=0.5,
    allows_zero=False,
)
def tsuji(e):
    """Kelvin–Voigt in δ^(5/4), with the same restitution. The force rises steeply, as δ^¼."""
    return _logarithmic_damping(math.sqrt(5.0), e)


def _logarithmic_damping(scale, e):
    """Return ``scale`` times ζ, the damping ratio with which an oscillator keeps the part e of its speed.

    e is the speed after half a cycle, relative to the speed at its start.
    """
    decrement = log(e)
    return -scale * decrement / math.sqrt(math.pi * math.pi + decrement * decrement)


@register_law(
    "Jankowski",
    "2005, Earthq Eng Struct Dyn 34:595",
    "2ξ, ξ = (9√5/2)(1−e²)/{e[e(9π−16)+16]}",
    (0.164, 1.0),
    "C, recomputed",
    exponent=1.5,
    rate_exponent=0.25,
    mass_power=0.5,
    approach_only=True,
    allows_zero=False,
)
def jankowski(e):
    """For pounding of buildings: damped on approach only, so never pulls. The force rises as δ^¼."""
    return 9.0 * math.sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))


@register_law(
    "Kuwabara & Kono",
    "1987, Jpn J Appl Phys 26:1230",
    "root of e′ = e at 1 m/s",
    (0.0, 1.0),
    "derived; after the paper",
    exponent=1.5,
    rate_exponent=0.5,
    mass_power=0.4,
    allows_zero=False,
)
def kuwabara_kono(e):
    """Viscoelastic spheres: a free impact at 1 m/s has the prescribed e.

    Slower impacts rebound better and faster ones worse: restitution depends on f v₀^(1/5).
    """
    if not e > 0.0:
        return math.inf
    return viscoelastic_factor(e)


@register_law(
    "Newton",
    "1687, Principia; Moreau 1988, CISM Courses 302:1",
    "none: v⁺ = −e v⁻",
    (0.0, 1.0),
    "C",
    rigid=True,
)
def newton_impact(e):
    """Rigid walls, the limit of all the others: impulses of no duration in place of a force."""
    return 0.0 * e


__all__ = ["CONTACT_LAWS", "LAW_COUNT", "damping_factor", "is_rigid"]

_LAWS = tuple(CONTACT_LAWS.values())
LAW_COUNT = len(_LAWS)
_factor = dispatch_by_number([law.damping_factor for law in _LAWS])
# ANY_EXPONENT in REQUIRED_EXPONENTS: any exponent n is allowed; ANY_EXPONENT in RATE_EXPONENTS: p = n.
ANY_EXPONENT = -1.0
REQUIRED_EXPONENTS = tuple(ANY_EXPONENT if law.exponent is None else law.exponent for law in _LAWS)
RATE_EXPONENTS = tuple(ANY_EXPONENT if law.rate_exponent is None else law.rate_exponent for law in _LAWS)
# the least restitution e that each law allows: 0, or a number whose reciprocal 1/e does not overflow
LEAST_RESTITUTIONS = tuple(0.0 if law.allows_zero else 1e-300 for law in _LAWS)
MASS_POWERS = tuple(law.mass_power for law in _LAWS)
APPROACH_ONLY = tuple(int(law.approach_only) for law in _LAWS)
IS_RIGID = tuple(int(law.rigid) for law in _LAWS)


def damping_factor(law, restitution):
    """Return the factor f(e) of the damping for the restitution e, in law number ``law``, from 1."""
    return _factor(law - 1, restitution)


def is_rigid(law):
    """Return whether the law with the number ``law`` has impulses instead of a force.

    A user's law has a force.
    """
    return law <= LAW_COUNT and IS_RIGID[law - 1] != 0
