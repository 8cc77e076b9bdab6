"""Imports inside the layers, which import-linter checks, and the rules of files and tests."""

import ast
import graphlib
import itertools
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from functools import cache
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pytest

import chain_impact
from tests import tiers
from tests.scheduling import SHARED_PROCESS, SLOWEST
from tests.tiers import EXTRAS, IMPORTING, subjects

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "fmu_src" / "chain_impact"
SLAVE = ROOT / "fmu_src" / "slave.py"
SCRIPTS = [file for file in PACKAGE.rglob("*.js") if file.parent.name != "vendor"]
MODULES = sorted(PACKAGE.rglob("*.py"))
LONGEST, LONGEST_OF_TESTS = 400, 500  # lines of a file of the package, and of one of the tests
LONGEST_NAME = 70  # characters of the name of a test
WIDEST = {".js": 140, ".c": 120, ".h": 120}  # characters of a line; ruff checks the lines of Python
FILES = {
    ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): file
    for file in MODULES
}
"""Dotted name → file."""


@cache
def nodes(file):
    """Return the imports and attributes in a file."""
    kinds = (ast.Import, ast.ImportFrom, ast.Attribute)
    return [node for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(node, kinds)]


def imported(file):
    """Yield the names of all modules that a file imports anywhere."""
    for node in nodes(file):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." * node.level + (node.module or "")


def others(file, allowed_packages):
    """Return the modules that a file imports and that are not in packages ``allowed``."""
    return [
        m
        for m in imported(file)
        if not any(m == package or m.startswith(f"{package}.") for package in allowed_packages)
    ]


def test_kernel_and_slave_import_only_what_they_may():
    allowed_packages = (
        "dataclasses",
        "fractions",
        "functools",
        "math",
        "numpy",
        "typing",
        "chain_impact.kernel",
    )
    imported = {file: others(file, allowed_packages) for file in (PACKAGE / "kernel").rglob("*.py")}
    imported[SLAVE] = others(SLAVE, (*sys.stdlib_module_names, "pythonfmu"))
    assert {file: modules for file, modules in imported.items() if modules} == {}


def needs(file):
    """Yield the modules of the package that a file imports, for types, too."""
    for node in nodes(file):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                full_name = f"{node.module}.{alias.name}"
                yield full_name if full_name in FILES else node.module


def test_no_files_need_each_other_not_even_for_types():
    """Only the list of public names is exempt, because it imports all public modules."""
    needed_files = {
        name: set(needs(file)) - {"chain_impact"} for name, file in FILES.items() if name != "chain_impact"
    }
    graphlib.TopologicalSorter(needed_files).prepare()  # raises an error with the cycle


def test_no_parts_of_a_folder_need_each_other():
    """Parts are modules and inner folders."""
    folders = defaultdict(lambda: defaultdict(set))
    for name, needed_name in (
        (name, needed_name) for name, file in FILES.items() for needed_name in needs(file)
    ):
        steps = zip(name.split("."), needed_name.split("."), strict=False)
        common = [*itertools.takewhile(lambda pair: pair[0] == pair[1], steps)]
        if len(common) < min(name.count("."), needed_name.count(".")) + 1:
            parts = (module.split(".")[len(common)] for module in (name, needed_name))
            folders[tuple(common)][next(parts)].add(next(parts))
    assert len(folders) > 30
    for needed_parts in folders.values():
        graphlib.TopologicalSorter(needed_parts).prepare()  # raises an error with the cycle


def test_folders_of_pages_have_no_cycle_and_scripts_a_heading():
    """oxlint finds circles of files."""
    imported_folders = {}
    for file in SCRIPTS:
        text = file.read_text(encoding="utf-8")
        assert re.match(r"// [A-Z]", text), file.name
        imported_folders.setdefault(file.parent.name, set()).update(re.findall(r'from "\.\./(\w+)/', text))
    graphlib.TopologicalSorter(imported_folders).prepare()  # raises an error with the cycle


def test_docs_import_nothing_of_the_tests_and_benchmarks_only_helpers():
    """Tests of the docs import both; so the arrows go one way. Helpers import no room of the tests."""
    assert {name for name in imports_of("docs/tools") if name.startswith("tests.")} == set()
    needed_modules = {name for name in imports_of("benchmarks") if name.startswith("tests.")}
    assert {name for name in needed_modules if not name.startswith("tests.helpers.")} == set()
    assert {
        name for name in imports_of("tests/helpers") if re.match(r"benchmarks|tests\.(?!helpers\b)", name)
    } == set()


def imports_of(folder):
    """Return the modules that the files of a folder import."""
    return {name for file in (ROOT / folder).rglob("*.py") for name in imported(file)}


def test_only_the_lowering_imports_numba():
    """With prebuilt kernels only a law of the user's own needs numba, when it is compiled."""
    compilers = ("numba", "llvmlite")
    users = {file.stem for file in MODULES if len(others(file, compilers)) < len([*imported(file)])}
    of_lowering = {"collecting", "dual_numbers", "entry_points", "functions", "law", "record_type"}
    assert users == {"built_in", "lower", "numba_parts", *of_lowering}


def test_one_module_imports_the_parts_of_numba_that_may_move():
    """A new version of numba may move or change what is in these packages; the other names are documented."""
    parts = re.compile(r"numba\.(?!extending$)")
    files = [*MODULES, *(ROOT / "benchmarks").rglob("*.py")]
    assert {file.stem for file in files if any(map(parts.match, imported(file)))} == {"numba_parts"}


def test_the_package_can_be_imported_where_it_is_not_installed():
    """The build of a wheel imports the package before a version exists, to lower the kernel."""
    program = f"import sys; sys.path.insert(0, {str(PACKAGE.parent)!r})\n" + (
        "from importlib import metadata\n"
        "distribution = metadata.Distribution.from_name\n"
        "def others(name):\n"
        "    if name == 'chain-impact':\n"
        "        raise metadata.PackageNotFoundError(name)\n"
        "    return distribution(name)\n"
        "metadata.Distribution.from_name = others\n"
        "import chain_impact\n"
    )
    process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stderr


def redirections(file):
    """Return the names in a file that change the streams or the working folder of the whole process."""
    calls, streams = {"redirect_stdout", "redirect_stderr", "chdir", "fchdir", "dup2"}, {"stdout", "stderr"}
    for node in nodes(file):
        if isinstance(node, ast.ImportFrom):
            yield from {alias.name for alias in node.names} & calls
        elif isinstance(node, ast.Attribute):
            yield from {node.attr} & (calls if isinstance(node.ctx, ast.Load) else streams)


def test_modules_are_short_and_redirect_no_stream_of_the_process():
    """The caller may have other threads, so the process-wide streams and folder must stay."""
    files = [*MODULES, SLAVE]
    lengths = {file: len(file.read_text("utf-8").splitlines()) for file in [*files, *SCRIPTS]}
    assert {file: length for file, length in lengths.items() if length >= LONGEST} == {}
    lengths = {file: len(file.read_text("utf-8").splitlines()) for file in (ROOT / "tests").rglob("*.py")}
    assert {file: length for file, length in lengths.items() if length >= LONGEST_OF_TESTS} == {}
    assert {file.name: stream_lines for file in files if (stream_lines := [*redirections(file)])} == {}


def test_no_line_of_javascript_or_c_is_too_long():
    files = [*SCRIPTS, *PACKAGE.rglob("*.[ch]")]
    long_lines = [
        f"{file.name}:{number}"
        for file in files
        for number, line in enumerate(file.read_text("utf-8").splitlines(), 1)
        if len(line) > WIDEST[file.suffix]
    ]
    assert long_lines == []


def test_every_module_stands_in_a_layer():
    """import-linter checks only modules that are listed in a layer."""
    settings = tomllib.loads((ROOT / "layers.toml").read_text(encoding="utf-8"))
    rooms, *_ = settings["tool"]["importlinter"]["contracts"]
    layers = {name for layer in rooms["layers"] for name in layer.split(" | ")}
    top = {file.stem if file.name != "__init__.py" else file.parent.name for file in PACKAGE.glob("*.py")}
    top |= {folder.parent.name for folder in PACKAGE.glob("*/__init__.py")}
    assert {name for name in top - {PACKAGE.name} if f"chain_impact.{name}" not in layers} == set()


def test_each_module_has_tests_and_each_test_file_a_module():
    rooms = {file.parent.name for file in PACKAGE.glob("*/__init__.py")}
    files = {
        file: [PACKAGE / name for name in subjects(file)] for file in (ROOT / "tests").rglob("test_*.py")
    }
    named_files = {*itertools.chain(*files.values())}
    assert {str(file) for file in named_files if not file.is_file()} == set()
    modules = {file for file in MODULES if file.name != "__init__.py"} | {*SCRIPTS}
    assert {str(file) for file in modules - named_files} == set()
    mirrored = [file for file in files if file.relative_to(ROOT / "tests").parts[0] in rooms]
    assert [str(file) for file in mirrored if not files[file]] == []


def test_the_modules_of_a_test_file_come_from_its_name_and_its_lines():
    tests = ROOT / "tests"
    assert "kernel/advance.py" in subjects(tests / "kernel" / "test_advance.py")
    assert "kernel/advance.py" in subjects(tests / "kernel" / "test_indices.py")
    assert subjects(tests / "scenarios" / "test_random_scenes.py") == []


@pytest.mark.parametrize(
    ("but", "expected"), [(1, ["one"]), ("two", ["two"]), (["one", "three"], ["one", "three"])]
)
def test_a_marked_test_has_some_cases_in_the_quick_tier(but, expected):
    mark = pytest.mark.full("takes long", but=but).mark
    option = SimpleNamespace(full=False, without_quick=False)
    hook = SimpleNamespace(pytest_deselected=lambda items: None)
    names = [f"test_it.py::test[{case}]" for case in ("one", "two", "three")]
    items = [SimpleNamespace(nodeid=name, get_closest_marker=lambda _: mark) for name in names]
    tiers.leave_out(config := SimpleNamespace(option=option, args=[], hook=hook), items)
    assert [item.nodeid for item in items] == [f"test_it.py::test[{case}]" for case in expected]
    if but == "two":
        with pytest.raises(pytest.UsageError, match=r"no such case: test_it.py::test\[two\]"):
            tiers.leave_out(config, [SimpleNamespace(nodeid=names[0], get_closest_marker=lambda _: mark)])


def test_the_order_of_the_tests_names_files_that_exist():
    tests = [*(ROOT / "tests").rglob("test_*.py")]
    paths = {file.relative_to(ROOT).as_posix() for file in tests}
    assert {*SLOWEST, *SHARED_PROCESS, *SHARED_PROCESS.values()} - paths == set()


IMPORT = re.compile(r"^(?:from ([\w.]+) )?import (?:\(([^)]*)\)|([^\n(#]+))", re.MULTILINE)


@cache
def imported_with(file):
    """Return all modules that the import of a file imports, also by other files of the repository."""
    text, module_names = re.sub(r'""".*?"""', "", file.read_text(encoding="utf-8"), flags=re.DOTALL), set()
    for module, *names in IMPORT.findall(text):
        for name in re.findall(r"(?:^|,)\s*([\w.]+)", "".join(names)):
            module_names |= {module, f"{module}.{name}"} if module else {name}
    own_files = (
        top / f"{name.replace('.', '/')}.py" for name in [*module_names] for top in (ROOT, PACKAGE.parent)
    )
    return module_names.union(*(imported_with(module) for module in own_files if module.is_file()))


def test_no_public_name_loads_what_draws():
    """matplotlib takes a second; what draws imports it in its functions."""
    files = (FILES[module] for module in chain_impact._HOMES.values())
    modules = {module for file in files for module in imported_with(file)}
    assert {"chain_impact.cli", "chain_impact.pictures"} & modules == set()  # their __init__.py import more
    loaded = {module.partition(".")[0] for module in modules}
    assert "numpy" in loaded
    assert {"matplotlib", "rich"} & loaded == set()


def normalized(package):
    """Return the name of a package in the form in which indexes compare names."""
    return re.sub(r"[-_.]+", "_", package).lower()


def test_files_that_import_what_the_quick_tier_lacks_are_named_with_it():
    """Files of the same name count as one."""
    lacked = itertools.chain(*(EXTRAS[extra] for extra in EXTRAS.keys() - {"check", "pandas", "test"}))
    packages, imports = {*map(normalized, lacked)}, defaultdict(set)
    homes = metadata.packages_distributions()
    lacking = {name for name in homes if packages & {*map(normalized, homes[name])}}
    lacking |= IMPORTING.keys()  # also where they are not installed
    for file in (ROOT / "tests").rglob("test_*.py"):
        imports[file.name] |= {module.partition(".")[0] for module in imported_with(file)} & lacking
    marked_modules = {name: {module for module in IMPORTING if name in IMPORTING[module]} for name in imports}
    assert {*itertools.chain(*IMPORTING.values())} - imports.keys() == set()
    assert {
        name: modules - imports[name] for name, modules in marked_modules.items() if modules - imports[name]
    } == {}
    assert {name for name, modules in imports.items() if modules} == {
        name for name in marked_modules if marked_modules[name]
    }


def test_names_of_tests_are_short():
    files = (ROOT / "tests").rglob("test_*.py")
    names = {name for file in files for name in re.findall(r"^def (test_\w+)", file.read_text("utf-8"), re.M)}
    assert {name for name in names if len(name) > LONGEST_NAME} == set()


def test_no_file_imports_from_a_file_of_tests_or_fixtures():
    line = re.compile(r"^ *(?:from|import) [^#\n]*\b(?:test_\w+|conftest)\b", re.MULTILINE)
    importing_files = [
        file for file in (ROOT / "tests").rglob("*.py") if line.search(file.read_text("utf-8"))
    ]
    assert importing_files == []


def private(file, of_self):
    """Return the private attributes that a file takes from ``self``, or else from other objects."""
    return {
        node.attr
        for node in nodes(file)
        if isinstance(node, ast.Attribute)
        and re.match(r"_[a-z]", node.attr)
        and (isinstance(node.value, ast.Name) and node.value.id == "self") == of_self
    }


def test_only_one_helper_uses_private_parts_of_chains_and_instances():
    names = set().union(
        *(
            private(PACKAGE / "simulation" / f"{name}.py", True)
            for name in ("chain", "instance", "derivatives")
        )
    )
    assert {"_instance", "_kernel", "_tangents"} <= names
    use = re.compile(rf"\.(?:{'|'.join(names)})\b")
    files = [file for room in ("tests", "benchmarks", "docs/tools") for file in (ROOT / room).rglob("*.py")]
    users = [file for file in files if use.search(file.read_text("utf-8")) and private(file, False) & names]
    assert [file.name for file in users] == ["kernel_calls.py"]


TOOL_FILES = [
    file for room in ("benchmarks", "docs/tools", "packaging", ".ci") for file in (ROOT / room).rglob("*.py")
]


@pytest.mark.parametrize("file", TOOL_FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_what_is_beside_the_package_uses_no_private_part_of_it(file):
    """A private function or class may be renamed with its module alone."""
    imports = [
        node
        for node in nodes(file)
        if isinstance(node, ast.ImportFrom) and "chain_impact" in str(node.module)
    ]
    names = {alias.asname or alias.name for node in imports for alias in node.names}
    parts = [
        node.attr
        for node in nodes(file)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in names
    ]
    assert [name for name in [*names, *parts] if re.match(r"_[a-z]", name)] == []


HELPERS, SCENARIOS = ROOT / "tests" / "helpers", ROOT / "tests" / "scenarios"
# the scenarios are no package: processes that a test starts import its functions as ``tests.scenarios.…``
GUIDES = [SCENARIOS / "guide.py", HELPERS / "__init__.py", *HELPERS.glob("*/__init__.py")]


@pytest.mark.parametrize("guide", GUIDES, ids=lambda guide: guide.parent.name)
def test_the_guide_of_a_folder_names_everything_in_it_once(guide):
    page = ast.get_docstring(ast.parse(guide.read_text("utf-8")))
    modules, folders = guide.parent.glob("*.py"), guide.parent.glob("*/__init__.py")
    part_names = {file.stem for file in modules} | {file.parent.name for file in folders}
    assert sorted(re.findall(r"``(\w+)``", page)) == sorted(part_names - {guide.stem})
