"""Optional packages: they are in the extras of pyproject.toml, because only some users need them."""

from __future__ import annotations

import json
import re
import sys
from importlib import import_module
from importlib.metadata import PackageNotFoundError, distribution
from typing import Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

from chain_impact.console import quoted_word


class MissingExtraError(ImportError):
    """Raised when an optional package is not installed.

    The message is one line, with the command that installs the package.
    """


def require(package: str, extra_name: str) -> Any:
    """Import a package that belongs to an extra, and return it.

    Raises:
        MissingExtraError: when the package is not installed.
    """
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        # if the package is installed, but lacks another package, the error is raised unchanged
        if error.name != package.partition(".")[0]:
            raise
        advice = how_to_install(extra_name)
        raise MissingExtraError(f"{package} is not installed: {advice}", name=package) from None


def how_to_install(extra_name: str) -> str:
    """Return the command that installs the packages of an extra that are missing.

    If none is missing by its metadata, the command adds the whole extra to this installation of chain-impact.
    """
    package = distribution("chain-impact")
    # a requirement of an extra has the form "mujoco<5,>=3.3; extra == 'convert'"
    requirements = [text.partition(";") for text in package.requires or ()]
    missing_packages = [
        needed.strip()
        for needed, _, condition in requirements
        if re.search(rf"""extra == ['"]{extra_name}['"]""", condition) and not _is_installed(needed)
    ]
    origin = json.loads(package.read_text("direct_url.json") or "{}")
    url = origin.get("url", "")
    if url.startswith("file:"):
        package_text = f"{url2pathname(urlsplit(url).path)}[{extra_name}]"
    else:
        prefix = f"{origin['vcs_info']['vcs']}+" if "vcs_info" in origin else ""
        package_text = f"chain-impact[{extra_name}]" + (f" @ {prefix}{url}" if url else "")
    packages_text = " ".join(map(quoted_word, missing_packages or [package_text]))
    return f"{quoted_word(sys.executable)} -m pip install {packages_text}"


def _is_installed(requirement: str) -> bool:
    """Return whether any version of the package of a requirement, such as "mujoco<5", is installed."""
    name = re.split(r"[^\w.-]", requirement.strip(), maxsplit=1)[0]
    try:
        distribution(name)
    except PackageNotFoundError:
        return False
    return True
