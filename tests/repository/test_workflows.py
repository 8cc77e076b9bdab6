"""GitHub workflows and pre-commit hooks run existing commands, on each supported Python."""

import os
import re
import shlex
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
WORKFLOWS = {file.stem: file for file in (ROOT / ".github" / "workflows").glob("*.yml")}
TOOLS = {"diff", "echo", "pip", "uv"}  # programs of the machine, or of an earlier step


def read(name):
    return yaml.safe_load(WORKFLOWS[name].read_text(encoding="utf-8"))


def steps(name):
    return [step for job in read(name)["jobs"].values() for step in job["steps"]]


def commands(name):
    for step in steps(name):
        yield from (shlex.split(part) for part in step.get("run", "").split(" && ") if part)


def check(program, *arguments):
    """Check the presence of a program, and of the script, module or extra that it gets."""
    if program == "python" and arguments[0] != "-m":
        assert (ROOT / arguments[0]).is_file()
    elif program == "python":
        assert find_spec(arguments[1])
        extras = (re.fullmatch(r"\.\[(\w+)\]", argument) for argument in arguments)
        assert {extra[1] for extra in extras if extra} <= PROJECT["optional-dependencies"].keys()
    elif program not in TOOLS:
        assert os.access(ROOT / program, os.X_OK)


@pytest.mark.parametrize("name", WORKFLOWS)
def test_a_workflow_runs_what_there_is_and_may_only_read(name):
    for command in commands(name):
        check(*command)
    assert all(re.search(r"@(release/)?v\d+$", step["uses"]) for step in steps(name) if "uses" in step)
    assert read(name)["permissions"] == {"contents": "read"}
    writing = {job for job, parts in read(name)["jobs"].items() if "permissions" in parts}
    assert writing == ({"upload"} if name == "release" else set())


def test_each_python_that_is_promised_is_tried():
    heads = (
        re.fullmatch(r"Programming Language :: Python :: (3\.\d+)", classifier)
        for classifier in PROJECT["classifiers"]
    )
    promised = {head[1] for head in heads if head}
    matrix = read("tests")["jobs"]["quick"]["strategy"]["matrix"]
    assert {*matrix["python"], *(entry["python"] for entry in matrix["include"])} == promised
    wheel = (ROOT / ".ci" / "check_wheel.py").read_text(encoding="utf-8")
    assert set(re.findall(r"\"python(3\.\d+)\"", wheel)) == promised


def test_the_hooks_before_a_commit_are_checks_of_ci():
    text = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    entries = {hook["entry"] for repository in yaml.safe_load(text)["repos"] for hook in repository["hooks"]}
    gate = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    checks = re.findall(r"^begin \"\" (\.ci/\w+)(?: --without-tests)?$", gate, re.MULTILINE)
    assert entries == {*checks} == {".ci/check"}
