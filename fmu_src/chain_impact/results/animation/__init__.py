"""Animations of a recording: a page for the browser, or a film."""

from chain_impact.results.animation.animate import FORMATS, SIZE, AnimationError, animate
from chain_impact.results.animation.pacing import IMPACT_TIME

__all__ = ["FORMATS", "IMPACT_TIME", "SIZE", "AnimationError", "animate"]
