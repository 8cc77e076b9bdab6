"""Linear combinations of stages, compiled for the coefficients of a method."""

from chain_impact.kernel.jit import jit


def combination(row):
    """Compile ``out = base + h Σ_j row[j] k_j``, unrolled over the stages j that the row names.

    The compiled function takes (stages, base, h, out), with the stages k_j the rows of ``stages``, which may
    be longer than ``base`` and ``out``.
    """
    names, coefficients = tuple(row), tuple(row.values())
    count = len(row)

    @jit
    def combine(stages, base, h, out):
        for j in range(len(base)):
            total = 0.0
            for m in range(count):
                total += coefficients[m] * stages[names[m], j]
            out[j] = base[j] + h * total

    return combine
