"""What a method is, and the numbers of the methods. The list of them is in methods.py."""

EXPLICIT, IMPLICIT = 0, 1  # step.method: the one at work


class Method:
    """A method of integration, as data.

    Its functions take the instance d and the size h of a step, in the variable that the step runs in.

    Attributes:
        name: what `solver.method` calls it.
        order: the error of a step over its length goes as this power of h.
        safety: part of the size that the last error suggests, for the next step.
        implicit: whether it is stable however stiff the equations are; its steps are counted as implicit.
        measures_start: whether ``prepare`` finds a size for the first step after an event.
        onset_size: size of the first step of a contact over its time scale, at a tolerance of 1.
        onset_order: the error of that step goes as this power of its size.
        rate_at_end: whether it has the rate at the end of a step, as the first stage of the next one.
        lands: whether a step is made anew to land on an event, as its end is better than its dense output.
        dense_evaluations: right-hand sides that the dense output takes; without any it is there from the
            start, but for what ``dense_output`` adds.
        prepare: make ready at the start of a step; returns the h to begin with, at most the given one.
        attempt: try a step from `step.state_end`; the result is in `work.y`. Returns the error relative to
            the tolerance: at most 1 for a step to accept; not finite when f was not.
        finish: set what the method keeps of the step that was tried, when it has become the last one.
        dense_output: make the dense output of the last step.
        bound_curvatures: set what it knows of bounds on |g̈| over the last step, ``search.curvature``.
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
