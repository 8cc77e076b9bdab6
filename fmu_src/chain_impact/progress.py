"""What is told of work that takes long: to a callback how much is done, and to a logger what it is."""

from __future__ import annotations

import logging
from collections.abc import Callable

Progress = Callable[[float], None]
"""Called with the fraction done, 0…1."""
log = logging.getLogger("chain_impact")
"""Tells at the level INFO what takes seconds, and at DEBUG what is done in between."""
log.addHandler(logging.NullHandler())


def log_once(sentence: str, seconds: float) -> None:
    """Log what is done once and then kept, and about how many seconds it takes."""
    log.info("%s (about %.0f s, then kept)", sentence, seconds, extra={"seconds": seconds})


def silent(_done: float) -> None:
    """Show nothing of the progress."""
