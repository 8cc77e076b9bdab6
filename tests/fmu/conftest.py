"""FMUs of all kinds, and a clean process to import them in.

Every test here runs on all kinds of FMU, unless it is about one of them. In this process the FMU could pick
up the package, numba, or modules that a test has loaded. So what concerns its use runs in an environment of
its own that holds an importer and pythonfmu, and not this package.
"""

import inspect
import json
import subprocess
import sys
import textwrap
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from chain_impact.export.fmu import build_fmu

HERE = Path(__file__).parent
Clean = Callable[..., Any]


KINDS = {
    "pythonfmu": {"target": "pythonfmu"},
    "native": {"target": "native"},
    "fmi3": {"target": "native", "fmi": 3},
}
"""The kinds of FMU → how to build one. The first two are for FMI 2.0."""


class OnDemand(dict[str, str]):
    """The FMU of each model, built when a test first asks for it: name of the model → path."""

    def __init__(self, kind: str, folder: Path) -> None:
        self.kind, self.folder = kind, folder

    def __missing__(self, name: str) -> str:
        self[name] = str(build_fmu(name, self.folder, **KINDS[self.kind]))
        return self[name]


@pytest.fixture(scope="session", params=KINDS)
def target(request) -> str:
    """The kind of FMU."""
    return request.param


@pytest.fixture(scope="session", params=["pythonfmu", "native"])
def fmi2(request, all_fmus) -> dict[str, str]:
    """The FMU of each model, of both kinds for FMI 2.0."""
    return all_fmus[request.param]


@pytest.fixture(scope="session", params=["native", "fmi3"])
def strict(request, all_fmus) -> dict[str, str]:
    """The FMU of each model, of both kinds that have the C interface."""
    return all_fmus[request.param]


@pytest.fixture(scope="session")
def all_fmus(tmp_path_factory) -> dict[str, dict[str, str]]:
    """The FMUs of each model: kind → name of the model → path."""
    folder = tmp_path_factory.mktemp("fmus")
    return {kind: OnDemand(kind, folder / kind) for kind in KINDS}


@pytest.fixture(scope="session")
def fmus(all_fmus, target) -> dict[str, str]:
    """The FMU of each model: name of the model → path."""
    return all_fmus[target]


@pytest.fixture(scope="session")
def native(all_fmus) -> dict[str, str]:
    """The native FMU of each model."""
    return all_fmus["native"]


@pytest.fixture(scope="session")
def clean_python(tmp_path_factory) -> Path:
    """A Python that knows fmpy and pythonfmu, and neither this package nor numba."""
    folder = tmp_path_factory.mktemp("clean")
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    python = folder / "bin" / "python"
    packages = [f"{name}=={version(name)}" for name in ("pythonfmu", "fmpy")]
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *packages]
    subprocess.run(install, check=True)
    return python


@pytest.fixture(scope="session")
def clean(clean_python) -> Clean:
    """Run ``function(*arguments)`` in the clean Python; all that it uses is what it imports and importer.py.

    Or, in place of that, the ``module`` interface.py. Arguments and result pass as JSON, which keeps doubles
    to the last bit.
    """

    def run(function: Callable[..., Any], *arguments: Any, module: str = "importer") -> Any:
        program = "\n".join(
            (
                "import json, sys",
                f"sys.path.insert(0, {str(HERE)!r})",
                f"from {module} import *",
                textwrap.dedent(inspect.getsource(function)),
                f"result = {function.__name__}(*json.loads(sys.stdin.read()))",
                # after whatever importer and FMU have printed
                "print('\\n' + json.dumps(result))",
            )
        )
        done = subprocess.run(
            [clean_python, "-I", "-X", "faulthandler", "-c", program],
            input=json.dumps(arguments),
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
        return json.loads(done.stdout.splitlines()[-1])

    return run


@pytest.fixture(scope="session")
def run(clean) -> Clean:
    """Run a function in a clean process that has interface.py."""
    return lambda function, *arguments: clean(function, *arguments, module="interface")


@pytest.fixture(scope="session")
def fmi3(all_fmus) -> dict[str, str]:
    """The FMU of each model."""
    return all_fmus["fmi3"]
