"""Documentation for users: commands parse, snippets run, and tables are complete."""

import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
import unicodedata
from html import unescape
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import pytest

from chain_impact import cli
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import scene_keys
from docs.tools import build_site, generate, images, try_it
from tests.helpers.tools.processes import Processes

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
# pages that the build of the site makes
MADE_PAGES = {try_it.PAGE, *(notebook.with_suffix(".md") for notebook in NOTEBOOKS)}
DOCS = sorted(page for page in (ROOT / "docs").rglob("*.md") if page not in MADE_PAGES)
PAGES = [*ROOT.glob("*.md"), *(ROOT / "models").glob("*.md"), *DOCS]
PAGES.sort(key=lambda page: (page != ROOT / "README.md", page))  # the first page is in the quick tier
# commands that a page may show, besides scripts of the repository
KNOWN_COMMAND = re.compile(
    r"(\.venv/bin/)?(chain-impact|python -m pytest|pip|ruff|oxlint|mypy|lint-imports)\b"
    r"|(apt-get|uv|source|python3 -m venv|pytest)\b"
)


def parametrized(pages):
    return pytest.mark.parametrize("page", pages, ids=lambda page: str(page.relative_to(ROOT)))


class Block(NamedTuple):
    """A fenced block: its language, its file name, and its text."""

    language: str
    title: str
    text: str


def fenced(page):
    blocks = re.finditer(
        r"^```(\w*)(?: title=\"([^\"\n]*)\")?\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S
    )
    return [Block(block[1], block[2] or "", block[3].rstrip("\n")) for block in blocks]


def blocks(page, language):
    """Return the fenced blocks of a page in a language."""
    return [block.text for block in fenced(page) if block.language == language]


def commands(page):
    """Yield the arguments of chain-impact or our build script, in sh blocks and inline code of a page."""
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


def test_version_and_number_of_laws_are_right():
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    lines = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    assert {f"{name}: {project[key]}" for name, key in CITED.items()} <= {*lines}
    for page in ("README.md", "docs/index.md", "docs/paper.md", "CITATION.cff"):
        counts = re.findall(r"\b(\d+) (?:contact )?laws\b", (ROOT / page).read_text(encoding="utf-8"))
        assert counts == [str(len(CONTACT_LAWS))]


CITED = {"title": "name", "license": "license", "version": "version"}


def test_all_pages_together_have_at_most_29000_words():
    """Words are counted as by ``wc -w``: a word ends at white space."""
    top_folders = ("benchmarks", "docs", "fmu_src", "models", "packaging", "tests", ".ci")
    pages = [*ROOT.glob("*.md"), *(page for folder in top_folders for page in (ROOT / folder).rglob("*.md"))]
    counts = {page: len(page.read_text(encoding="utf-8").split()) for page in pages if page not in MADE_PAGES}
    assert counts.keys() > {*PAGES}
    assert sum(counts.values()) <= 29_000


def test_commands_parse_links_lead_to_files_and_tables_are_up_to_date():
    faults, count = [], 0
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for arguments in commands(page):
            cli.parser().parse_args(arguments)
            count += 1
        links = re.findall(r"\]\(([^)#:]*)(?:#([^)]*))?\)", text)
        files = {target: page.parent / target for target, _ in links if target}
        faults += [
            (page.name, anchor)
            for target, anchor in links
            if anchor and anchor not in anchors(files.get(target, page))
        ]
        faults += [
            (page.name, target) for target, file in files.items() if not (file.exists() or file in MADE_PAGES)
        ]
        faults += [(page.name, command) for command in others(page) if not is_known(command)]
        if page in DOCS and text != generate.filled(text):
            faults.append((page.name, "run: python -m docs.tools.generate"))
    assert faults == []
    assert count > 10
    names = {block[1] for page in DOCS for block in generate.BLOCK.finditer(page.read_text(encoding="utf-8"))}
    assert names == generate.TABLES.keys()


def anchors(page):
    """Return the anchors of a page: given ids, and its headings as ``slug`` gives them."""
    text = page.read_text(encoding="utf-8")
    return {slug(heading) for heading in re.findall(r"^#+ (.*)$", text, re.M)} | set(
        re.findall(r"(?:\{ ?#|id=\")([\w-]+)", text)
    )


def slug(heading):
    """Return the anchor that Python-Markdown makes from a heading."""
    letters = unicodedata.normalize("NFKD", heading).encode("ascii", "ignore").decode()
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", letters).strip().lower())


def others(page):
    """Yield all commands in the sh blocks of a page."""
    for line in "\n".join(blocks(page, "sh")).splitlines():
        yield from line.partition("  #")[0].split(" && ")


def is_known(command):
    """Return whether it is a program of KNOWN_COMMAND or a script of the repository."""
    script = re.match(
        r"(?:\.venv/bin/)?python (?:([\w/]+)\.py|-m (tests|docs|benchmarks)[. ]([\w.]+))", command
    )
    if script:
        file = script[1] or f"{script[2]}/{script[3].replace('.', '/')}"
        return (ROOT / f"{file}.py").is_file()
    return KNOWN_COMMAND.match(re.sub(r"^(?:[A-Z_]+=\S+ )+", "", command))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Run Python in a folder: (exit code, standard output, standard error)."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "fmu_src"), "MPLBACKEND": "Agg", "PYTHONUTF8": "1"}
    printed = tmp_path_factory.mktemp("printed")
    processes = Processes(printed, ROOT / "tests", sys.executable, "-W", "error", env=environment)
    yield lambda folder, *arguments: processes.call(["", "program", [str(folder), *arguments]], "reader")
    processes.end()


@pytest.fixture(scope="module")
def folder(tmp_path_factory, run):
    """Return a folder with the models and FMUs; the README's first command makes build/FourLinkBox.fmu."""
    folder = tmp_path_factory.mktemp("reader")
    (folder / "docs" / "images").mkdir(parents=True)
    (folder / "models").symlink_to(ROOT / "models")
    for arguments in ((), ("--target", "native", "-o", "build/native"), ("--fmi", "3", "-o", "build/fmi3")):
        code, _, errors = run(folder, "-m", "chain_impact.cli", "build", *arguments)
        assert code == 0, errors
    return folder


def chain_impact(line):
    """Return the arguments of a line that runs chain-impact or our build script; None for any other line."""
    match = re.search(r"(chain-impact|build_fmu\.py) (.*)", line.partition("  #")[0])
    if match and match[1] == "build_fmu.py":
        return ["build", *shlex.split(match[2])]
    return shlex.split(match[2]) if match else None


def without_usual_picture(arguments):
    """Return the arguments without the usual picture of a model, which tests/pictures draws."""
    model = arguments[1] if arguments[0] == "simulate" else None
    return arguments[:2] if arguments[2:] == ["--plot", f"{model}.png"] else arguments


def lines_of(text):
    return [line.rstrip() for line in text.strip().splitlines()]


@pytest.mark.full("needs compilers and other tools", but="README.md")
@parametrized([page for page in PAGES if any(block.language in ("sh", "python") for block in fenced(page))])
def test_a_page_runs_from_top_to_bottom(page, folder, run):
    """Write the files and run the programs and commands in a new folder; compare the output with the page."""
    printed = ""
    for language, title, text in fenced(page):
        if title == "printed":
            assert lines_of(printed) == lines_of(text)
        elif title and language != "py":
            (folder / title).write_text(text, encoding="utf-8")
        elif language == "python":
            # the snippet runs as a separate program, as for a reader
            (folder / "snippet.py").write_text(text, encoding="utf-8")
            code, printed, errors = run(folder, "snippet.py")
            assert code == 0, f"{text}\n{errors}"
        elif language == "sh":
            for line in text.splitlines():
                if (arguments := chain_impact(line)) is not None:
                    quick_arguments = without_usual_picture(arguments)
                    code, printed, errors = run(folder, "-m", "chain_impact.cli", *quick_arguments)
                    assert code == 0, f"{line}\n{errors}"


@pytest.mark.full("needs a sweep and a film")
@pytest.mark.parametrize("program", [name for name in images.PROGRAMS if "chain_impact.cli" in name])
def test_a_command_draws_an_image_of_the_docs(program, folder, run):
    arguments = shlex.split(program)
    code, _, errors = run(folder, *arguments)
    assert code == 0, errors
    (image,) = (word for word in arguments if word.startswith("docs/images/"))
    assert (folder / image).stat().st_size > 0
    assert (ROOT / image).is_file()


def test_the_tests_of_the_first_contribution_pass():
    page = (ROOT / "docs" / "development" / "recipes.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^pytest (.*)$", page, re.M)
    process = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "0", *command.split()],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (process.returncode, process.stderr) == (0, "")
    assert re.match(r"\.{8,} ", process.stdout)


def test_notebooks_are_committed_without_outputs():
    assert len(NOTEBOOKS) >= 5
    for notebook in NOTEBOOKS:
        cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        code = [cell for cell in cells if cell["cell_type"] == "code"]
        assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


def test_the_fields_and_the_code_that_the_computation_page_names_exist():
    text = (ROOT / "docs" / "computation.md").read_text(encoding="utf-8")
    parts = "|".join(instance_dtype(2, 3).names)
    fields = re.findall(rf"`((?:{parts})(?:\.\w+)+)`", text)
    assert len(fields) > 15
    for field in fields:
        dtype = instance_dtype(2, 3)
        for name in field.split("."):
            dtype = dtype.base[name]
    files = set(re.findall(r"`(kernel/[\w/]+\.py)`", text))
    assert len(files) > 10
    assert all((ROOT / "fmu_src" / "chain_impact" / file).is_file() for file in files)


def test_the_scene_reference_has_every_key():
    text = generate.scene_reference()
    for key, entry in scene_keys():
        if "default" in entry.metadata and not key.endswith(
            ("links", "walls", ".wall", ".slider", "signals")
        ):
            assert f"`{key.rpartition('.')[2]}`" in text, key


def test_a_site_that_fails_keeps_its_exit_code(tmp_path, monkeypatch):
    monkeypatch.setattr(build_site, "SITE", tmp_path / "no site")
    monkeypatch.setattr(build_site, "NOTEBOOKS", [])
    for module, name in ((build_site, "make_pages"), (build_site, "write_words"), (try_it, "write_page")):
        monkeypatch.setattr(module, name, lambda *_: None)
    monkeypatch.setattr(build_site.sys, "argv", ["build_site"])
    monkeypatch.setattr(build_site.subprocess, "run", lambda *_, **__: SimpleNamespace(returncode=3))
    assert build_site.main() == 3


def test_the_glossary_explains_its_words_on_all_pages(tmp_path, monkeypatch):
    monkeypatch.setattr(build_site, "WORDS", tmp_path / "words.txt")
    build_site.write_words()
    lines = (tmp_path / "words.txt").read_text(encoding="utf-8").splitlines()
    assert "*[onset]: the moment at which a contact begins" in lines
    assert all(re.fullmatch(r"\*\[[\w -]+\]: [^\\*`\[]{10,}( \[.*\])?", line) for line in lines)
    assert len(lines) > 20


def test_the_page_to_try_has_every_model_and_links_to_its_page(tmp_path, monkeypatch):
    monkeypatch.setattr(try_it, "PAGE", tmp_path / "try_it.md")
    try_it.write_page()
    text = (tmp_path / "try_it.md").read_text(encoding="utf-8")
    model_links = re.findall(r'<a href="try/(\w+)\.html" target="try">', text)
    assert model_links[0] == "four_link_box"
    assert sorted(model_links) == sorted(model_names())
    for model in model_links:
        assert f'<a href="models/{model}.html">' in text
        assert (ROOT / "docs" / "models" / f"{model}.md").is_file()


@pytest.mark.parametrize("model", ["elastic_ball", "hopper"])
def test_a_page_of_a_model_has_its_scene_file(model):
    shown_text = unescape(re.search(r"<code>(.*)</code>", try_it.scene_file(model), re.S)[1])
    assert shown_text == (ROOT / "models" / model / "scene.toml").read_text(encoding="utf-8")


def test_the_start_page_of_the_site_opens_with_a_page_that_simulates():
    film = '<p><img alt="Four links" src="images/four_link_box.gif" /></p>'
    assert try_it.begin_with_page(f"<h1>chain-impact</h1>{film}") == f"<h1>chain-impact</h1>{try_it.FRAME}"
    with pytest.raises(RuntimeError, match=r"^the start page has 0 films"):
        try_it.begin_with_page("<h1>chain-impact</h1>")


def test_links_of_the_gallery_lead_to_their_pages():
    source = (ROOT / "docs" / "models" / "index.md").read_text(encoding="utf-8")
    pictures = re.findall(
        r"\]\(\.\./images/(\w+)\.png\)\{[^}]*\}\]\((\w+)\.md\)<br>\[`(\w+)`\]\((\w+)\.md\)", source
    )
    assert sorted(pictures) == [(name,) * 4 for name in sorted(model_names())]
    link = '<a href="{0}.html"><img src="{0}.png" /></a><br /><a href="{0}.html"><code>{0}</code></a>'
    led = try_it.lead_to_simulations("".join(link.format(name) for name in model_names()))
    for name in model_names():
        assert f'<a href="../try/{name}.html"><img src="{name}.png" />' in led
        assert f'<a href="{name}.html"><code>{name}</code>' in led
    with pytest.raises(RuntimeError, match=r"^1 pictures of \d+ models have a link$"):
        try_it.lead_to_simulations(link.format("whip"))
