"""Texts that tell users why derivatives end (kernel/tangent/trust.py), are missing or are inexact."""

from chain_impact.kernel.tangent.trust import (
    AT_FRICTION_LIMIT,
    AT_LEAST_SPEED,
    FORCE_JUMPS,
    GRAZING,
    NOT_CONVERGED,
    SIMULTANEOUS_CHANGES,
    SIMULTANEOUS_ONSETS,
    SLIDES_FROM_REST,
    SLOW_CHANGE,
)

REASONS = {
    GRAZING: "its point arrives so slowly that the tolerance leaves open whether it arrives at all",
    AT_LEAST_SPEED: "its approach speed is contact.minimum_impact_speed, which the law takes for a "
    "smaller speed",
    SIMULTANEOUS_ONSETS: "several points arrive at one moment, and the motion afterwards depends on which is "
    "first",
    FORCE_JUMPS: "the force of its contact law jumps where the point turns",
    NOT_CONVERGED: "the implicit step from there on is too long for them: their iteration does not converge",
}
"""Code → reason why derivatives end. NOT_CONVERGED can apply at any time, the other reasons at an impact at a
wall or at a stop of the slider."""

REASONS_AT_STOPS = REASONS | {
    GRAZING: "its joint reaches the stop so slowly that the tolerance leaves open whether it does so at all",
    AT_LEAST_SPEED: "its joint's speed is stop.minimum_impact_speed, which the law takes for a smaller speed",
    SIMULTANEOUS_ONSETS: "several contacts begin at one moment, and the motion afterwards depends on which "
    "is first",
    FORCE_JUMPS: "the moment of its contact law jumps where the joint turns back",
}
"""Code → reason why derivatives end at an impact at a stop of a joint."""

REASONS_OF_FRICTION = {
    SLOW_CHANGE: "its sliding or sticking ends so slowly that the tolerance leaves open whether it ends",
    AT_FRICTION_LIMIT: "the force that would hold it is as large as static friction can be, so it may stick "
    "or slide",
    SIMULTANEOUS_CHANGES: "the sliding or sticking of several ends at one moment, and it matters which is "
    "first",
    SLIDES_FROM_REST: "it begins to slide from rest, and a small speed against its direction would first be "
    "stopped",
}
"""Code → reason why derivatives end because of dry friction."""

NO_RISE = (
    "there is no derivative by {parameter} at 0: the motion with a short rise need not be near the motion "
    "without one"
)
"""The sentence for a signal with a rise of 0, with respect to which the motion has no derivative."""

NO_LESS = "there is no derivative by {parameter} at 0, as friction cannot be less"
"""The sentence for a friction of 0, with respect to which the motion has no derivative."""

ONE_SIDED = (
    "the derivative by {parameter} is for an earlier time only: its signal bends at the start of the run"
)
"""The sentence for a parameter that shifts a bend or jump of a signal, if this is at the start of the run and
makes accelerations of the chain or of a wall jump."""

LEFT_OPEN = (
    "derivatives may be off by {share:.2g} of the largest, as the tolerance leaves open when sliding and "
    "sticking end while the chain comes to rest"
)
"""The sentence for derivatives with an error, because the tolerance leaves open when sliding or sticking
ends."""
