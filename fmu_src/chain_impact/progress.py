"""The progress of long work: a callback gets the finished fraction, and a logger gets messages."""

from __future__ import annotations

import logging
from collections.abc import Callable

Progress = Callable[[float], None]
"""Called with the fraction done, 0…1."""
log = logging.getLogger("chain_impact")
"""Reports at the level INFO work that takes seconds, and at DEBUG the steps in between."""
log.addHandler(logging.NullHandler())


def log_once(sentence: str, seconds: float) -> None:
    """Log the start of work whose result is kept, and about how many seconds it takes."""
    log.info("%s (about %.0f s, then kept)", sentence, seconds, extra={"seconds": seconds})


def silent(_done: float) -> None:
    """Show nothing of the progress."""
