"""The progress of long work: a callback for the finished fraction, and a logger for messages."""

from __future__ import annotations

import logging
from collections.abc import Callable

Progress = Callable[[float], None]
"""A function that is called with the finished fraction of some work, from 0 to 1."""
log = logging.getLogger("chain_impact")
"""The package's logger: INFO tells of long work and of what this work leaves out, DEBUG of single steps."""
log.addHandler(logging.NullHandler())


def log_once(sentence: str, seconds: float) -> None:
    """Log that work begins that takes about ``seconds`` [s] and is done once, because the result is kept.

    ``sentence`` describes the work.
    """
    log.info("%s (about %.0f s, then kept)", sentence, seconds, extra={"seconds": seconds})


def no_progress(_share: float) -> None:
    """Do nothing; this is the ``Progress`` of work that shows none."""
