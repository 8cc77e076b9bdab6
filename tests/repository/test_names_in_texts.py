"""A reader finds the capital names and the files that comments and docstrings name."""

import itertools
import re
from functools import cache
from pathlib import Path

import pytest

import chain_impact
from chain_impact.kernel.record.counts import Counts
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.scene.reading import keys_of
from chain_impact.scene.scene import Scene

ROOT = Path(__file__).parents[2]
ROOMS = (".ci", "benchmarks", "docs/tools", "fmu_src", "packaging", "tests")
FILES = [
    file
    for room in ROOMS
    for file in sorted((ROOT / room).rglob("*.*"))
    if file.suffix in (".py", ".js", ".c", ".h") and file.parent.name != "vendor"
]
PACKAGE = ROOT / "fmu_src"
PUBLIC = {*chain_impact.__all__}
WORDS = {
    *("ACM", "ARM", "BDF", "BIT", "BLAS", "BSD", "CC0", "CIE", "CIELAB", "CPU", "CRC", "CSV", "CVODE"),
    *("D65", "DEBUG", "DOP853", "DT_NEEDED", "ELF", "FMI", "FMU", "FNV", "GUID", "HTML", "IEEE", "II"),
    *("IIA", "INFO", "IV", "JSON", "LC_BUILD_VERSION", "LC_CODE_SIGNATURE", "LC_LOAD_DYLIB", "LC_SYMTAB"),
    *("LEB128", "LLVM", "MB", "MJ", "MJCF", "MPLBACKEND", "NULL", "PE", "PMMA", "PNG", "POSIX"),
    *("PYTHONPATH", "README", "RK4", "SDND108", "SHA", "SHT_DYNAMIC", "SHT_DYNSYM", "SI", "SIAM"),
    *("SIGBUS", "SIGNUM", "SVG", "TOML", "URDF", "URI", "USSR", "UTF", "WCAG"),
}
"""Abbreviations, units, and words of other works."""
NAME = re.compile(r"(?<![\w=#%\\])[A-Z][A-Z\d]+(?:_[A-Z\d]+)*(?![\w=′])")
COMMAND = re.compile(r"``[^`]*[ =\[][^`]*``|\S+(?: \[?[A-Z_]{3,}\b[\]…]?){2,}")
"""A command or a setting, with words in place of its arguments."""
FILE_NAME = re.compile(r"(?<![\w/.<{*-])(?!SVG\.js|__init__)([\w/]*\w\.(?:py|js|c|h))\b(?!\()")
"""The name of a file, with or without folders. SVG.js is a library; each folder has an __init__.py."""
PLAIN = re.compile(r"``([^` =\[]+)``|noqa: [A-Z0-9, ]+")
"""A quoted name, and numbers of rules."""
STRINGS = r"""|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'"""
PYTHON = re.compile(r"""\#[^\n]*(?:\n *\#[^\n]*)*|"{3}.*?"{3}|'{3}.*?'{3}""" + STRINGS, re.DOTALL)
STRING_OR_COMMENT = re.compile(
    r"""//[^\n]*(?:\n\s*//[^\n]*)*|/\*.*?\*/|`(?:\\.|[^`\\])*`""" + STRINGS, re.DOTALL
)
"""The comments and the strings of Python, and of JavaScript and C. Comments in successive lines are one."""


@cache
def read(file):
    """Return the texts of a file, comments and docstrings, and the words in its code."""
    source, texts, code, at = file.read_text("utf-8"), [], [], 0
    for part in (PYTHON if file.suffix == ".py" else STRING_OR_COMMENT).finditer(source):
        start, end = part.span()
        code.append(source[at:start])
        line = source[source.rfind("\n", 0, start) + 1 : start]
        is_text = part[0][0] in "#/" or (part[0].startswith('"""') and not line.strip())
        (texts if is_text else code).append(part[0])
        at = end
    code.append(source[at:])
    return [PLAIN.sub(r"\1", text) for text in texts], {*re.findall(r"\w+", " ".join(code))}


def named(text, name):
    """Yield the files that a text names, also as a module before the name and a point."""
    ends = {*re.findall(r"([\w/]*\w\.(?:py|js|c|h))\b", text)}
    ends |= {f"{module}.py" for module in re.findall(rf"(\w+)\.{name}\b", text)}
    yield from (file for file in FILES for end in ends if file.as_posix().endswith(f"/{end}"))


def unknown(file):
    """Return the names in the texts of a file that a reader does not find."""
    texts, code = read(file)
    defined = WORDS | PUBLIC | code | {*NAME.findall(" ".join(itertools.chain(*map(COMMAND.findall, texts))))}
    named_in_texts = [
        (name, text) for text in texts for name in {*NAME.findall(COMMAND.sub("", text))} - defined
    ]
    explained = {
        name
        for name, text in named_in_texts
        if any(name in read(named_file)[1] for named_file in named(text, name))
    }
    return sorted({name for name, _ in named_in_texts} - explained)


def unclear_files(file):
    """Return the names of files in the texts of a file that do not mean exactly one file of the repository.

    A name alone means the file of this name in the same folder, or else the only one in the package, or else
    the only one in the repository. A name with folders means the only file whose path ends so.
    Lines `# Tests:` have paths in the package.
    """
    unclear = set()
    for end in FILE_NAME.findall(re.sub("# Tests:.*", "", "\n".join(read(file)[0]))):
        matching = [matching_file for matching_file in FILES if matching_file.as_posix().endswith(f"/{end}")]
        in_package = [matching_file for matching_file in matching if matching_file.is_relative_to(PACKAGE)]
        if file.parent / end not in matching and 1 not in (len(matching), len(in_package)):
            unclear.add(end)
    return sorted(unclear)


@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.parametrize("faults", [unknown, unclear_files], ids=["capital names", "files"])
def test_a_reader_finds_what_texts_name(room, faults):
    files = [file for file in FILES if file.is_relative_to(ROOT / room)]
    unexplained = {file.name: names for file in files if (names := faults(file))}
    assert files
    assert unexplained == {}


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("# rule_language.py, forces/friction.py, record/friction.py\n", []),
        ("# rules_of_language.py\n", ["rules_of_language.py"]),
        ("# as friction.py does\n", ["friction.py"]),
        ("# as force/friction.py does\n", ["force/friction.py"]),
        ("# beside itself.py\n", []),
        ("# Tests: progress.py\n", []),
        ("name = 'missing.py'\n", []),
    ],
)
def test_an_unclear_file_is_found(tmp_path, monkeypatch, text, names):
    file = tmp_path / "itself.py"
    file.write_text(text, "utf-8")
    monkeypatch.setattr(f"{__name__}.FILES", [*FILES, file])
    assert unclear_files(file) == names


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ('"""See OTHER_NAME."""\n', ["OTHER_NAME"]),
        ("x = 1  # at most LEAST\n", ["LEAST"]),
        (
            "LEAST = 1\nx = 1  # at most LEAST [m], by SHORTEST\n# of pictures/film/arrow_scale.py\n",
            ["SHORTEST"],
        ),
        ("LEAST = 1\nx = 1  # at most LEAST [m], by `arrow_scale.SHORTEST_ARROW`\n", []),
        ("# SHORTEST_ARROW of an FMU (pictures/film/arrow_scale.py)\n", []),
        ('"""The command: ``tool --name NAME``; NAME may be empty."""\n', []),
        ('"""The command: tool FIRST LAST WAY."""\n', []),
    ],
)
def test_a_name_that_exists_nowhere_is_found(tmp_path, text, names):
    (tmp_path / "file.py").write_text(text, "utf-8")
    assert unknown(tmp_path / "file.py") == names


def test_the_overview_names_what_there_is():
    """The name before the path of a file is defined in this file."""
    text, package = (ROOT / "docs/development/overview.md").read_text("utf-8"), PACKAGE / "chain_impact"
    pairs = re.findall(r"(\w+)(?:` in `|` \| `| +)((?:\w+/)+\w+\.py)", text)
    paths = {*re.findall(r"(?<![\w/])(?:\w+/)+(?:\w+\.\w+)?", text)} - {"resources/model.bin"}
    assert len(pairs) > 15
    assert {path for path in paths if not ((package / path).exists() or (ROOT / path).is_dir())} == set()
    defined = {path: (package / path).read_text("utf-8") for _, path in pairs}
    definition = r"^(?:def |class )?{}\b"
    assert [pair for pair in pairs if not re.search(definition.format(pair[0]), defined[pair[1]], re.M)] == []


def test_the_docs_name_fields_of_the_record():
    """A name such as `chain.length` is that of a field in the record, or of a key of scenes."""
    layout, keys = instance_dtype(*Counts(2, 1)), {name for name, _ in keys_of(Scene)}
    pages = [ROOT / "docs/computation.md", *(ROOT / "docs/development").glob("*.md")]
    named_fields = {
        name for page in pages for name in re.findall(r"`([a-z_]+\.[a-z_]+)`", page.read_text("utf-8"))
    }
    named_fields = {
        name for name in named_fields if not name.endswith((".py", ".js", ".c", ".md", ".toml", ".yml"))
    } - keys
    fields = {f"{part}.{field}" for part in layout.names for field in layout[part].base.names or ()}
    assert len(named_fields) > 20
    assert named_fields - fields == set()


def test_the_recipes_name_capital_names_of_their_files():
    page = (ROOT / "docs" / "development" / "recipes.md").read_text("utf-8")
    recipes = re.split(r"\n## .*\n", page)[3:]
    named_in_recipes = [(name, text) for text in recipes for name in {*NAME.findall(text)} - WORDS]
    assert len(named_in_recipes) > 5
    assert [
        name
        for name, text in named_in_recipes
        if not any(name in read(file)[1] for file in named(text, name))
    ] == []


def test_each_abbreviation_is_in_use():
    assert WORDS - {name for file in FILES for text in read(file)[0] for name in NAME.findall(text)} == set()
