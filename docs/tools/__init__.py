"""Programs that make parts of the docs: each runs in the root as ``python -m docs.tools.NAME``."""

from pathlib import Path

DOCS = Path(__file__).parents[1]
