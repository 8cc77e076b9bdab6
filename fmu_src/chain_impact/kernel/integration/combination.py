"""Linear combinations of stages: functions for the coefficients of a method."""


def combination(row):
    """Return a function for ``out = base + h Σ_j row[j] k_j``, unrolled over the stages j in the row.

    The function takes (stages, base, h, out), with the stages k_j the rows of ``stages``, which may
    be longer than ``base`` and ``out``.
    """
    names, coefficients = tuple(row), tuple(row.values())
    count = len(row)

    def combine(stages, base, h, out):
        for j in range(len(base)):
            total = 0.0
            for m in range(count):
                total += coefficients[m] * stages[names[m], j]
            out[j] = base[j] + h * total

    return combine


def combinations(one, two):
    """Return a function for the sums h Σ_j row[j] k_j of two rows, which reads each k_j once for both.

    The function takes (stages, h, first, second), the last two for the results.
    """
    names = tuple(sorted({*one, *two}))
    row_1, row_2 = (tuple(row.get(name, 0.0) for name in names) for row in (one, two))
    count = len(names)

    def combine(stages, h, first, second):
        for j in range(len(first)):
            total_1, total_2 = 0.0, 0.0
            for m in range(count):
                stage = stages[names[m], j]
                total_1 += row_1[m] * stage
                total_2 += row_2[m] * stage
            first[j], second[j] = h * total_1, h * total_2

    return combine


def sequence(first, *others):
    """Return a function that calls several functions, which return nothing, in turn with its arguments."""
    if not others:
        return first
    rest = sequence(*others)

    def both(d, h, *more):
        first(d, h, *more)
        rest(d, h, *more)

    return both
