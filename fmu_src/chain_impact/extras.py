"""Packages that only some users need: the extras of pyproject.toml."""

from __future__ import annotations

import json
import sys
from importlib import import_module
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from chain_impact.system import quoted

NAME = "chain-impact"
TOOLS = {"uv-receipt.toml": "uv tool", "pipx_metadata.json": "pipx"}
"""What installs a program in an environment of its own, by the file that it leaves in that environment."""


class MissingExtraError(ImportError):
    """A package is not installed; the message is one line and says how to get it."""


def require(package: str, extra: str) -> Any:
    """Import a package of an extra.

    Raises:
        MissingExtraError: when it is not installed.
    """
    try:
        return import_module(package)
    except ImportError as error:
        how = how_to_install(extra)
        raise MissingExtraError(f"{package} cannot be imported ({error}): {how}", name=package) from None


def how_to_install(extra: str) -> str:
    """The command that adds an extra to this installation, from where chain-impact was installed."""
    for receipt, tool in TOOLS.items():
        if Path(sys.prefix, receipt).is_file():
            return f"{tool} install --force {_requirement(extra)}"
    python = quoted(sys.executable)
    # an environment that uv made has no pip
    pip = f"{python} -m pip install" if find_spec("pip") else f"uv pip install --python {python}"
    return f"{pip} {_requirement(extra)}"


def _requirement(extra: str) -> str:
    """What pip is asked for: the folder, the file or the address that is installed, or else the name."""
    origin = _origin()
    url = origin.get("url", "")
    named = f"{NAME}[{extra}]"
    if "vcs_info" in origin:
        vcs = origin["vcs_info"]
        revision = vcs.get("requested_revision") or vcs["commit_id"]
        part = f"#subdirectory={origin['subdirectory']}" if origin.get("subdirectory") else ""
        return quoted(f"{named} @ {vcs['vcs']}+{url}@{revision}{part}")
    from urllib.request import url2pathname  # takes 20 ms

    path = Path(url2pathname(urlsplit(url).path))
    if url.startswith("file:") and path.exists():
        editable = "-e " if origin.get("dir_info", {}).get("editable") else ""
        return f"{editable}{quoted(f'{path}[{extra}]')}"
    return quoted(f"{named} @ {url}" if url.startswith("http") else named)


def _origin() -> dict[str, Any]:
    """What pip or uv has written down of where the package came from; nothing when that was by its name."""
    try:
        written = distribution(NAME).read_text("direct_url.json")
    except PackageNotFoundError:
        return {}
    return json.loads(written) if written else {}
