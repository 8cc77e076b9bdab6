"""The class of integration methods, and their numbers. The list of the methods is in methods.py."""

EXPLICIT, IMPLICIT = 0, 1  # step.method: the current method


class Method:
    """A method of integration, as data.

    Its functions take the instance d and the size h of a step, in the integration variable of the step.

    Attributes:
        name: its name in `solver.method`.
        order: the error of a step over its length is proportional to this power of h.
        safety: factor on the size of the next step that the last error suggests.
        implicit: whether it is stable however stiff the equations are; its steps are counted as implicit.
        measures_start: whether ``prepare`` finds a size for the first step after an event.
        onset_size: size of the first step of a contact over its time scale, at a tolerance of 1.
        onset_order: the error of that step is proportional to this power of its size.
        rate_at_end: whether it evaluates the rate at the end of a step, as the first stage of the next one.
        lands: whether a step is repeated so that it ends at an event, as its end is more accurate than its
            dense output.
        dense_evaluations: right-hand sides that the dense output needs; with 0 ``finish`` sets it, except for
            what ``dense_output`` adds.
        prepare: prepare a step at its start; returns the size h to try first.
        attempt: try a step from `step.state_end`: set the state at its end, `trial.state`, and conclude the
            trial (trial.py) with the error relative to the tolerance, which is not finite if f was not.
        finish: store what the method needs of the step that was tried, once it has become the last one.
        dense_output: set the dense output of the last step.
        bound_curvatures: set the bounds on |g̈| over the last step that it knows, ``search.curvature``.
    """

    name: str
    order: int
    safety: float
    implicit: bool
    measures_start: bool
    onset_size: float
    onset_order: float
    rate_at_end: bool
    lands: bool
    dense_evaluations: int
    prepare: object
    attempt: object
    finish: object
    dense_output: object
    bound_curvatures: object

    def __init__(self, **entries):
        for name, value in entries.items():
            setattr(self, name, value)
