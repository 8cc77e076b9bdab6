"""What users read: the commands parse, the snippets run, the tables are complete."""

import importlib.util
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from chain_impact import cli
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.layout import instance_dtype
from chain_impact.scene import scene_keys

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "models").glob("*/README.md")],
)
GUIDES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]  # whose commands are run in a bare folder
every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def blocks(page, language):
    """The fenced blocks of a page in a language."""
    text = page.read_text(encoding="utf-8")
    return [found[1].rstrip("\n") for found in re.finditer(rf"^```{language}\n(.*?)^```$", text, re.M | re.S)]


def commands(page):
    """The arguments of every chain-impact command of a page: in sh blocks, and in code within the text."""
    text = page.read_text(encoding="utf-8")
    lines = [line for block in blocks(page, "sh") for line in block.splitlines()]
    lines += re.findall(r"`((?:python build_fmu\.py|chain-impact) [^`\n]+)`", text)
    for line in lines:
        for part in line.split(" && "):
            _, program, arguments = re.match(r"(\S*/)?(\S+ build_fmu\.py|\S+)(.*)", part).groups()
            if program == "chain-impact":
                yield shlex.split(arguments)
            elif program.endswith("build_fmu.py"):
                yield ["build", *shlex.split(arguments)]


def test_the_readme_begins_with_two_lines_to_paste():
    build, test, *_ = blocks(ROOT / "README.md", "sh")
    assert "\n" not in build
    assert "\n" not in test
    assert build.endswith("build_fmu.py --simulate")
    assert test.endswith("-m pytest")


def test_the_readme_counts_the_laws():
    assert f" {len(CONTACT_LAWS)} laws" in (ROOT / "README.md").read_text(encoding="utf-8")


@every_page
def test_commands_parse(page):
    for arguments in commands(page):
        cli.parser().parse_args(arguments)


def test_there_are_commands_to_parse():
    assert sum(len(list(commands(page))) for page in PAGES) > 10


@every_page
def test_links_lead_to_files(page):
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        path = (page.parent / target).resolve()
        if path.parent == ROOT / "docs" / "models":  # generated from the model's README
            path = ROOT / "models" / path.stem
        assert path.exists(), target


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with build/FourLinkBox.fmu, as the README's first command leaves it, and a native one."""
    folder = tmp_path_factory.mktemp("reader")
    for arguments in ((), ("--target", "native", "-o", "build/native"), ("--fmi", "3", "-o", "build/fmi3")):
        assert run(folder, "-m", "chain_impact.cli", "build", *arguments) == 0
    return folder


def run(folder, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "fmu_src")}
    return subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, check=False).returncode


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if blocks(page, "python")],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_python_snippets_run(page, folder):
    for snippet in blocks(page, "python"):
        # as a program of its own, as a reader would
        (folder / "snippet.py").write_text(snippet, encoding="utf-8")
        assert run(folder, "-W", "error", "snippet.py") == 0, snippet


@pytest.mark.slow
@pytest.mark.parametrize("page", GUIDES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_run(page, folder):
    (folder / "pendulum.toml").write_text(blocks(ROOT / "docs" / "scene.md", "toml")[0])
    for block in blocks(page, "sh"):
        for line in block.splitlines():
            _, program, arguments = line.rpartition("chain-impact ")
            if program:
                assert run(folder, "-m", "chain_impact.cli", *shlex.split(arguments)) == 0, line


def test_the_fields_of_the_symbol_table_exist():
    text = (ROOT / "docs" / "computation.md").read_text(encoding="utf-8")
    fields = re.findall(
        r"`((?:model|contact|inputs|step|work|touch|candidate|search|implicit|rigid|output)(?:\.\w+)+)`", text
    )
    assert len(fields) > 30
    for field in fields:
        dtype = instance_dtype(2, 3)
        for name in field.split("."):
            dtype = dtype.base[name]


def test_the_code_that_the_computation_page_names_exists():
    text = (ROOT / "docs" / "computation.md").read_text(encoding="utf-8")
    files = set(re.findall(r"`(kernel/[\w/]+\.py)`", text))
    assert len(files) > 10
    assert all((ROOT / "fmu_src" / "chain_impact" / file).is_file() for file in files)


# --- the tables ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def generate():
    spec = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_placeholder_has_its_table(generate):
    wanted = {name for page in PAGES for name in re.findall(r"^\{\{ (\w+) \}\}$", page.read_text(), re.M)}
    assert wanted == generate.TABLES.keys()


def test_the_scene_reference_has_every_key(generate):
    text = generate.scene_reference()
    for key, entry in scene_keys():
        if "default" in entry.metadata and not key.endswith(("links", "walls")):
            assert f"`{key.rpartition('.')[2]}`" in text, key


def test_the_table_of_laws_has_every_law(generate):
    text = generate.contact_laws()
    assert all(f"| {law.number} | `{law.id}` | {law.source} |" in text for law in CONTACT_LAWS.values())


def test_the_table_of_stiffness_has_every_material(generate):
    text = generate.stiffnesses()
    assert "| steel | 207 | 0.3 | 2.145e+10 | 2.145e+10 |" in text
    assert all(f"| {name} |" in text for name in generate.MATERIALS)
