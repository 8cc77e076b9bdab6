"""A process that takes a fault and runs tests, for mutants.py."""

from __future__ import annotations

import ast
import functools
import importlib.abc
import importlib.util
import json
import os
import resource
import signal
import sys
from contextlib import suppress
from dataclasses import dataclass
from types import CodeType, FunctionType
from typing import Any

from common import ROOT
from mutations import Mutant

PACKAGE = ROOT / "fmu_src" / "chain_impact"
PYTEST = ["-q", "-n0", "-p", "no:cacheprovider", "--import-mode=importlib", "--tb=native"]
PATIENCE = 5.0  # times as long as without the fault, and 2 s, may a test take
MOST_MEMORY = 6 << 30  # bytes


class TooSlow(BaseException):
    """A test has taken too long."""


def stand_in() -> None:
    """Let instances have the plain kernel."""
    import numpy as np
    from plain_kernel import plain_kernel

    from chain_impact.simulation import instance

    instance.kernel_for = plain_kernel
    np.seterr(all="ignore")  # as the compiled kernel


def too_slow(*_: object) -> None:
    """The handler of the timer."""
    raise TooSlow


def passes(item: Any, limit: float) -> bool:
    """Run a test, for so long [s] at most; return whether it passes."""
    from _pytest.runner import runtestprotocol

    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        return all(report.passed for report in runtestprotocol(item, log=False, nextitem=None))
    except (Exception, TooSlow):  # outside of what pytest watches
        with suppress(Exception, TooSlow):
            item.session._setupstate.teardown_exact(None)
        return False
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def apart(mutant: Mutant, items: dict[str, Any], seconds: dict[str, float]) -> tuple[str, int]:
    """Run tests on a mutant in a copy of this process.

    Args:
        mutant: the fault.
        items: the tests by their names.
        seconds: names of those to run, and what each takes without the fault.

    Returns:
        What killed it, if anything did, and how many tests ran.
    """
    out, into = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os.close(out)
        silence = os.open(os.devnull, os.O_RDWR)
        for stream in (1, 2):
            os.dup2(silence, stream)
        limits = {key: 2.0 + PATIENCE * lasted for key, lasted in seconds.items()}
        most = int(2.0 * PATIENCE * sum(seconds.values())) + 60
        resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
        try:
            killer = killed_by(mutant, items, limits)
        except BaseException as error:
            killer = (type(error).__name__, 0)
        os.write(into, json.dumps(killer).encode())
        os._exit(0)
    os.close(into)
    with os.fdopen(out, "rb") as pipe:
        told = pipe.read()
    _, status = os.waitpid(child, 0)
    return tuple(json.loads(told)) if told else (f"ended by signal {status & 127}", 0)


def killed_by(mutant: Mutant, items: dict[str, Any], limits: dict[str, float]) -> tuple[str, int]:
    """Take the fault and run tests: the first that fails, and how many ran."""
    if not taken(mutant):
        return anew(mutant, limits)
    for module in list(sys.modules.values()):
        for one in list(vars(module).values()):
            if module.__name__.startswith(("chain_impact", "tests", "test_")) and hasattr(one, "cache_clear"):
                one.cache_clear()
    for ran, (key, limit) in enumerate(limits.items(), 1):
        if not passes(items[key], limit):
            return key, ran
    return "", len(limits)


def taken(mutant: Mutant) -> bool:
    """Give the function of a module the faulty code; whether that is all that changes."""
    own = getattr(sys.modules.get(module_name(mutant)), mutant.owner, None)
    if not isinstance(own, FunctionType) or own.__closure__ or own.__code__.co_filename != str(mutant.file):
        return False
    if mutant.owner in names_at_import():
        return False
    codes = compile(mutant.tree(), str(mutant.file), "exec").co_consts
    faulty = next(one for one in codes if isinstance(one, CodeType) and one.co_name == mutant.owner)
    if faulty == own.__code__:
        return False  # it is in a decorator
    own.__code__ = faulty
    return True


@functools.cache
def names_at_import() -> set[str]:
    """The names that stand outside of functions, anywhere: such functions make what others keep."""
    found = set()
    for file in PACKAGE.rglob("*.py"):
        for statement in ast.parse(file.read_text(encoding="utf-8")).body:
            if not isinstance(statement, ast.FunctionDef | ast.ImportFrom):
                found |= {getattr(one, "id", getattr(one, "attr", "")) for one in ast.walk(statement)}
    return found


def module_name(mutant: Mutant) -> str:
    """The name of the module that has the fault."""
    return ".".join((PACKAGE.name, *mutant.file.relative_to(PACKAGE).with_suffix("").parts))


class Faulty(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports a module with its fault."""

    def __init__(self, mutant: Mutant) -> None:
        self.mutant = mutant

    def find_spec(self, name: str, *_: object) -> Any:
        """The module, if it is this one."""
        if name != module_name(self.mutant):
            return None
        return importlib.util.spec_from_file_location(name, self.mutant.file, loader=self)

    def exec_module(self, module: Any) -> None:
        """Fill it."""
        exec(compile(self.mutant.tree(), str(self.mutant.file), "exec"), vars(module))


@dataclass
class Again:
    """A plugin that runs some tests in their order, until one fails."""

    limits: dict[str, float]
    killer: str = ""
    ran: int = 0

    def pytest_runtestloop(self, session: Any) -> bool:
        """Run them."""
        stand_in()
        items = {item.nodeid: item for item in session.items}
        for key, limit in self.limits.items():
            self.ran += 1
            if key in items and not passes(items[key], limit):
                self.killer = key
                break
        return True


def anew(mutant: Mutant, limits: dict[str, float]) -> tuple[str, int]:
    """Import all modules anew, one with its fault, and run tests."""
    import pytest

    for name in list(sys.modules):
        if name.partition(".")[0] in ("chain_impact", "tests", "plain_kernel") or name == "conftest":
            del sys.modules[name]
    sys.meta_path.insert(0, Faulty(mutant))
    files = sorted({key.partition("::")[0] for key in limits})
    plugin = Again(limits)
    code = pytest.main([*PYTEST, *files], plugins=[plugin]) if files else 0
    return plugin.killer or ("" if code in (0, 5) else f"pytest ended with {int(code)}"), plugin.ran
