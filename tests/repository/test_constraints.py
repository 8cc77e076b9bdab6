"""The versions with which .ci/run and the workflows test are those that pyproject.toml allows."""

import re
import tomllib
from itertools import product
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CONSTRAINTS = ".ci/constraints.txt"
PYTHONS = [
    classifier.rpartition(" ")[2] for classifier in PROJECT["classifiers"] if ":: Python :: 3." in classifier
]
# name in Python, processor and name of the operating system of the machines in .github/workflows
MACHINES = [
    ("linux", "x86_64", "Linux"),
    ("linux", "aarch64", "Linux"),
    ("darwin", "arm64", "Darwin"),
    ("win32", "AMD64", "Windows"),
]


def constraints():
    lines = (ROOT / CONSTRAINTS).read_text(encoding="utf-8").splitlines()
    return [Requirement(line) for line in lines if not line.startswith("#")]


def requirements():
    """Return the packages that the package and its extras need, but for the peers of the benchmarks."""
    extras = PROJECT["optional-dependencies"]
    lists = [PROJECT["dependencies"], *(extras[name] for name in extras if name != "bench")]
    return [Requirement(text) for texts in lists for text in texts if not text.startswith("chain-impact")]


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def environment(python, machine):
    """Return what markers ask about a Python and a machine."""
    platform, processor, system = machine
    names = {"sys_platform": platform, "platform_machine": processor, "platform_system": system}
    python_names = {"platform_python_implementation": "CPython", "implementation_name": "cpython"}
    return {"python_version": python, "python_full_version": f"{python}.9", **names, **python_names}


def misfits(needs, fixed, place):
    """Return the requirements for which the constraints do not name one version that is allowed."""

    def versions(name):
        rows = [row for row in fixed if canonical(row.name) == canonical(name)]
        return [row for row in rows if row.marker is None or row.marker.evaluate(place)]

    def fits(requirement):
        rows = versions(requirement.name)
        return len(rows) == 1 and requirement.specifier.contains(str(rows[0].specifier).removeprefix("=="))

    return [str(requirement) for requirement in needs if not fits(requirement)]


@pytest.mark.parametrize(("python", "machine"), [*product(PYTHONS, MACHINES)])
def test_each_needed_package_has_one_version_in_its_range(python, machine):
    assert misfits(requirements(), constraints(), environment(python, machine)) == [], (
        "run: python .ci/constraints.py"
    )


def test_each_constraint_is_one_exact_version():
    assert [str(row) for row in constraints() if not re.fullmatch(r"==[\w.+]+", str(row.specifier))] == []


def test_a_missing_a_doubled_and_a_forbidden_version_are_found():
    fixed = [Requirement(text) for text in ("rich==16.0", "numpy==2.1", "numpy==2.2; python_version>='3.12'")]
    needs = [Requirement(text) for text in ("rich>=13,<16", "numpy>=2", "scipy")]
    assert misfits(needs, fixed, environment("3.12", MACHINES[0])) == ["rich<16,>=13", "numpy>=2", "scipy"]
    assert misfits(needs, fixed, environment("3.11", MACHINES[0])) == ["rich<16,>=13", "scipy"]


def test_the_gate_and_each_installation_of_a_workflow_use_the_constraints():
    gate = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert {"PIP_CONSTRAINT", "UV_CONSTRAINT"} == set(
        re.findall(rf'(\w+)="\$scratch/chain-impact/{re.escape(CONSTRAINTS)}"', gate)
    )
    workflows = "".join(file.read_text("utf-8") for file in (ROOT / ".github" / "workflows").glob("*.yml"))
    installs = re.findall(r"pip install (.*'\.\[\w+\]')", workflows)
    assert len(installs) == len(re.findall(r"'\.\[", workflows)) > 0
    assert [install for install in installs if f"-c {CONSTRAINTS} " not in install] == []


def test_all_texts_give_the_same_line_for_contributors():
    line = "python3 -m venv .venv && .*PIP_COMPILE=0 (?:.venv/bin/)?pip install -q -e '(.*?)'"
    install_lines = [
        re.findall(line, (ROOT / name).read_text(encoding="utf-8"))
        for name in ("README.md", "CONTRIBUTING.md")
    ]
    assert install_lines == [[".[check]"], [".[check]"]]
