"""The progress of long work: a callback gets the finished fraction, and a logger gets messages."""

from __future__ import annotations

import logging
from collections.abc import Callable

Progress = Callable[[float], None]
"""A callback that gets the finished fraction, from 0 to 1."""
log = logging.getLogger("chain_impact")
"""The logger: level INFO for work that takes seconds, DEBUG for the steps of this work."""
log.addHandler(logging.NullHandler())


def log_once(sentence: str, seconds: float) -> None:
    """Log that work begins whose result is kept for later, and about how many seconds the work takes."""
    log.info("%s (about %.0f s, then kept)", sentence, seconds, extra={"seconds": seconds})


def silent(_done: float) -> None:
    """Do nothing: this callback shows no progress."""
