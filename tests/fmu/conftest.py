"""FMUs of all kinds, and a clean process that imports these FMUs.

Tests run on all kinds of FMU unless they concern one kind. In pytest's process an FMU could import the
package, numba, or modules of a test. Therefore tests of the use of FMUs run in a separate environment with an
importer and pythonfmu, without this package.
"""

import functools
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from lark import Lark

from tests.fmu.scenes import KINDS, OnDemand
from tests.helpers.tools.processes import Processes, make_environment
from tests.helpers.tools.shared import make_once, shared_folder

Clean = Callable[..., Any]


# the quick tier has tests of its own for native FMUs of both standards: test_interface.py and test_fmi3.py
OTHER_KIND = pytest.mark.full("another kind of FMU")
KIND = [pytest.param(kind, marks=[OTHER_KIND] * (kind != "pythonfmu")) for kind in KINDS]


@pytest.fixture(scope="session", params=KIND)
def target(request) -> str:
    """Return the kind of FMU."""
    return request.param


@pytest.fixture(scope="session", params=KIND[:2])
def fmi2(request, all_fmus) -> dict[str, str]:
    """Return the FMU of each model, of both kinds for FMI 2.0."""
    return all_fmus[request.param]


@pytest.fixture(scope="session", params=["native", "fmi3"])
def strict(request, all_fmus) -> dict[str, str]:
    """Return the FMU of each model, of both kinds with the C interface."""
    return all_fmus[request.param]


@pytest.fixture(scope="session")
def all_fmus(tmp_path_factory) -> dict[str, dict[str, str]]:
    """Return the FMUs of each model: kind → name of the model → path."""
    folder = shared_folder(tmp_path_factory, "fmus")
    return {kind: OnDemand(kind, folder / kind) for kind in KINDS}


@pytest.fixture(scope="session")
def fmus(all_fmus, target) -> dict[str, str]:
    """Return the FMU of each model: name of the model → path."""
    return all_fmus[target]


@pytest.fixture(scope="session")
def native(all_fmus) -> dict[str, str]:
    """Return the native FMU of each model."""
    return all_fmus["native"]


@pytest.fixture(scope="session")
def clean_python(tmp_path_factory) -> Path:
    """Return the Python of an environment with fmpy and pythonfmu, without this package and numba."""
    environment = shared_folder(tmp_path_factory, "clean") / "environment"
    make_once(environment, lambda folder: make_environment(folder, "pythonfmu", "fmpy"))
    return environment / "bin" / "python"


@pytest.fixture(scope="session")
def clean(clean_python, tmp_path_factory) -> Iterator[Clean]:
    """Yield a function that runs ``function(*arguments)`` in a process of the clean Python.

    ``function`` may use its own imports, and the names of importer.py or of another ``module``, if given.
    """
    folder = tmp_path_factory.mktemp("clean")
    processes = Processes(folder, Path(__file__).parent, clean_python, "-I", "-X", "faulthandler")
    yield lambda *call, module="importer": processes.run(*call, module=module)
    processes.end()


@pytest.fixture(scope="session")
def run(clean) -> Clean:
    """Run a function in a clean process that has interface.py."""
    return lambda function, *arguments: clean(function, *arguments, module="interface")


@pytest.fixture(scope="session")
def run3(clean) -> Clean:
    """Run a function in a clean process that has interface3.py."""
    return lambda function, *arguments: clean(function, *arguments, module="interface3")


@pytest.fixture(scope="session")
def fmi3(all_fmus) -> dict[str, str]:
    """Return the FMU for FMI 3.0 of each model."""
    return all_fmus["fmi3"]


@functools.cache
def _parsed(rule: str, name: str) -> Any:
    """Return the result of fmpy's parser for a name, which takes 10 ms."""
    return _PARSE(Lark(rule, start="name"), name)


_PARSE = Lark.parse


@pytest.fixture
def quick_names(monkeypatch) -> None:
    """Let fmpy parse a name once for all names that differ only in numbers."""
    monkeypatch.setattr(
        Lark, "parse", lambda rule, name: _parsed(rule.source_grammar, re.sub(r"\d+", "1", name))
    )
