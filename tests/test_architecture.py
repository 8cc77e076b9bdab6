"""The arrows of the architecture, kept by the imports themselves; import-linter keeps the layers."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "fmu_src" / "chain_impact"
SLAVE = ROOT / "fmu_src" / "slave.py"
LONGEST = 400  # lines of a file

MODULES = sorted(PACKAGE.rglob("*.py"))
# modules without a test file of their own → the one that tests them
TESTED_ELSEWHERE = {
    "results/animation/film_page.py": "results/animation/test_film.py",
    "cli/__main__.py": "cli/test_commands.py",
    "cli/animate.py": "cli/test_animate_command.py",
    "cli/build.py": "cli/test_commands.py",
    "cli/cache.py": "cli/test_commands.py",
    "cli/compare.py": "cli/test_commands.py",
    "cli/explore.py": "cli/test_explore_command.py",
    "cli/fit.py": "cli/test_fit_command.py",
    "cli/info.py": "cli/test_commands.py",
    "cli/options.py": "cli/test_commands.py",
    "cli/report.py": "cli/test_commands.py",
    "cli/simulate.py": "cli/test_commands.py",
    "cli/sweep.py": "cli/test_sweep_command.py",
    "cli/validate.py": "cli/test_validate_command.py",
    "compilation/collecting.py": "compilation/test_lower.py",
    "compilation/compilers.py": "compilation/test_library.py",
    "compilation/entry_points.py": "simulation/test_simulate.py",
    "compilation/errors.py": "compilation/test_library.py",
    "compilation/functions.py": "compilation/test_record_type.py",
    "compilation/law.py": "test_law_file.py",
    "compilation/law_file.py": "test_law_file.py",
    "compilation/places.py": "compilation/test_cache.py",
    "progress.py": "cli/test_progress.py",
    "fmu/arrays.py": "fmu/test_fmi3.py",
    "fmu/description.py": "fmu/test_build.py",
    "fmu/model_description.py": "fmu/test_fmi3_description.py",
    "fmu/documents.py": "fmu/test_build.py",
    "fmu/native_target.py": "fmu/test_native.py",
    "fmu/pythonfmu_target.py": "fmu/test_slave.py",
    "fmu/table.py": "fmu/test_native.py",
    "fmu/importer.py": "test_runs.py",
    "fmu/run.py": "test_runs.py",
    "simulation/record_scene.py": "test_runs.py",
    "simulation/instance.py": "simulation/test_simulate.py",
    "studies/fit/plot.py": "studies/fit/test_fit_plot.py",
    "studies/fit/result.py": "studies/fit/test_fit_result.py",
    "studies/fit/table.py": "studies/fit/test_fit_table.py",
    "studies/sweep/job.py": "studies/sweep/test_sweep.py",
    "scene/tables.py": "scene/test_scene.py",
    "scene/limits.py": "scene/test_checks.py",
    "fmu/check_references.py": "fmu/test_references.py",
    **{
        f"fmu/{name}.py": "fmu/test_validate.py"
        for name in (
            "archive",
            "check_description",
            "check_structure",
            "check_variables",
            "findings",
        )
    },
    "scene/half_planes.py": "test_walls.py",
    "scene/models.py": "test_models.py",
    "kernel/integration/combination.py": "kernel/integration/test_explicit.py",
    "kernel/integration/dop853.py": "kernel/integration/test_explicit.py",
    "kernel/events/kinds.py": "kernel/events/test_search.py",
    "kernel/events/relatch.py": "kernel/events/test_search.py",
    "kernel/events/sampling.py": "test_newton_rest.py",
    "kernel/dispatch.py": "kernel/laws/test_contact_laws.py",
    "kernel/integration/method.py": "kernel/integration/test_switching.py",
    "kernel/integration/methods.py": "kernel/integration/test_switching.py",
    "kernel/inlining.py": "kernel/chain/test_recursion.py",
    **{
        f"kernel/record/{name}.py": "kernel/test_record.py"
        for name in ("contacts", "fields", "given", "implicit", "instance", "outputs", "solver")
    },
    "variables/variable.py": "variables/test_table.py",
    "results/impacts.py": "results/test_impacts_of.py",
    "results/explore/description.py": "results/explore/test_kernel.py",
    "kernel/status.py": "variables/test_table.py",
    "kernel/tangent/blocks.py": "kernel/tangent/test_entry.py",
}


def imported(file):
    """The names of all modules that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." * node.level + (node.module or "")


def belongs(module, packages):
    return any(module == package or module.startswith(package + ".") for package in packages)


@pytest.mark.full("more cases", but=93)
@pytest.mark.parametrize("file", sorted((PACKAGE / "kernel").rglob("*.py")), ids=lambda file: file.name)
def test_the_kernel_imports_numbers_numpy_and_itself_only(file):
    allowed = ("dataclasses", "fractions", "math", "numpy", "chain_impact.kernel")
    assert [module for module in imported(file) if not belongs(module, allowed)] == []


@pytest.mark.full("takes long")
def test_only_the_lowering_imports_numba():
    """So that who has ready kernels needs no compiler."""
    users = {file.stem for file in MODULES if any(belongs(m, ("numba", "llvmlite")) for m in imported(file))}
    others = {"collecting", "dual_numbers", "entry_points", "functions", "law", "record_type"}
    assert users == {"lower", *others}


def test_the_slave_imports_the_standard_library_and_pythonfmu_only():
    allowed = (*sys.stdlib_module_names, "pythonfmu")
    assert [module for module in imported(SLAVE) if not belongs(module, allowed)] == []


def test_it_can_be_imported_where_it_is_not_installed():
    """As where its wheel is built: the kernel is lowered there, before there is a version."""
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
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def redirections(file):
    """The names in a file by which the streams or the working folder of the whole process are changed."""
    calls, streams = {"redirect_stdout", "redirect_stderr", "chdir", "fchdir", "dup2"}, {"stdout", "stderr"}
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            yield from {alias.name for alias in node.names} & calls
        elif isinstance(node, ast.Attribute):
            yield from {node.attr} & (calls if isinstance(node.ctx, ast.Load) else streams)


@pytest.mark.parametrize("file", [*MODULES, SLAVE], ids=lambda file: file.stem)
def test_nothing_of_the_process_is_redirected(file):
    """As the caller may have other threads."""
    assert list(redirections(file)) == []


@pytest.mark.full("more cases", but=249)
@pytest.mark.parametrize("file", [*MODULES, SLAVE], ids=lambda file: file.stem)
def test_files_are_short(file):
    assert len(file.read_text(encoding="utf-8").splitlines()) < LONGEST


@pytest.mark.full("more cases", but=234)
@pytest.mark.parametrize(
    "module", [file.relative_to(PACKAGE).as_posix() for file in MODULES if file.name != "__init__.py"]
)
def test_every_module_has_a_test(module):
    """tests/kernel/events/test_search.py for kernel/events/search.py, and so on."""
    path = Path(module)
    own = ROOT / "tests" / path.parent / f"test_{path.name}"
    elsewhere = TESTED_ELSEWHERE.get(module)
    assert own.is_file() or (elsewhere is not None and (ROOT / "tests" / elsewhere).is_file())


def test_no_module_is_named_in_vain():
    for module in map(Path, TESTED_ELSEWHERE):
        assert (PACKAGE / module).is_file()
        assert not (ROOT / "tests" / module.with_name(f"test_{module.name}")).is_file()


def test_every_module_stands_in_a_layer():
    """So that import-linter sees it."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    rooms, *_ = settings["tool"]["importlinter"]["contracts"]
    layers = {name for layer in rooms["layers"] for name in layer.split(" | ")}
    top = {file.stem if file.name != "__init__.py" else file.parent.name for file in PACKAGE.glob("*.py")}
    top |= {folder.parent.name for folder in PACKAGE.glob("*/__init__.py")}
    missing = {name for name in top - {PACKAGE.name} if f"chain_impact.{name}" not in layers}
    assert missing == set()
