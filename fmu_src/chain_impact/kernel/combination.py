"""Linear combinations of stages, compiled for the coefficients of a method."""

from chain_impact.kernel.jit import jit


def combination(row):
    """Compile ``out = base + h Σ_j row[j] k_j``, unrolled over the stages j that the row names.

    The compiled function takes (work, base, h, out), with the stages k_j the rows of ``work.stage``.
    """
    stages, coefficients = tuple(row), tuple(row.values())
    count = len(row)

    @jit
    def combine(work, base, h, out):
        for j in range(len(work.y)):
            total = 0.0
            for m in range(count):
                total += coefficients[m] * work.stage[stages[m], j]
            out[j] = base[j] + h * total

    return combine
