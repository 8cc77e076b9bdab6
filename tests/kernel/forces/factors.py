"""The damping factors of the contact laws."""

from tests.helpers.models.complex_laws import FAMILY as OF_FAMILY, WITH_MASS

# f(e) as quoted in reviews (sources: the registry), in the order of the FMU's enumeration
FACTORS = OF_FAMILY | {name: factor for name, (factor, *_) in WITH_MASS.items()}
