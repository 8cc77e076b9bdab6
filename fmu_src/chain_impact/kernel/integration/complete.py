"""The dense output of the last step, made when somebody needs it."""

from chain_impact.kernel.integration import explicit, implicit
from chain_impact.kernel.integration.dense import NOBODY, SOLVER


def complete(d, reader):
    """See that the last step has its dense output, before anything changes that it depends on.

    What only outputs need does not count as evaluations by the solver: the count does not depend on them.

    Args:
        d: the instance.
        reader: who needs it, OUTPUTS or the SOLVER.
    """
    known, d.step.dense_for = d.step.dense_for, max(d.step.dense_for, reader)
    if d.step.made_implicit:
        if known == NOBODY:
            implicit.dense_output(d)
        return
    if known == NOBODY:
        explicit.dense_output(d)
    if known < SOLVER <= reader:
        d.statistics.rhs_evaluations += explicit.DENSE_EVALUATIONS
