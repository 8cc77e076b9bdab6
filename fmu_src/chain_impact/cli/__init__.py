"""The command line ``chain-impact``."""

from chain_impact.cli.commands import main, parser

__all__ = ["main", "parser"]
