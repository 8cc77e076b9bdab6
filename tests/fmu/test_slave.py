"""What is of the pythonfmu FMU only: the slave, and what its wrapper makes of faults."""

import ast
import sys
import zipfile

import pytest

from chain_impact import load_scene
from chain_impact.compilation.errors import BuildError
from chain_impact.fmu import pythonfmu_target
from chain_impact.fmu.build import build_fmu
from chain_impact.fmu.pythonfmu_target import slave_source
from chain_impact.scene.scene import with_values
from tests.fmu.importer import Instance, refused


@pytest.fixture(scope="session")
def fmus(all_fmus):
    """Those of pythonfmu."""
    return all_fmus["pythonfmu"]


def test_another_value_makes_another_script(fmus, tmp_path):
    scene = with_values(load_scene("rod_drop"), {("contact", "stiffness"): 2e8})
    other = str(build_fmu(scene, tmp_path))
    scripts = [set(zipfile.ZipFile(path).namelist()) for path in (other, fmus["rod_drop"])]
    assert not {name for name in scripts[0] & scripts[1] if name.startswith("resources/chain_impact")}


def test_only_the_files_that_are_needed(fmus):
    names = zipfile.ZipFile(fmus["rod_drop"]).namelist()
    rest = [name for name in names if not name.startswith(("resources/pythonfmu/", "extra/"))]
    script, slave = sorted((name for name in rest if name.endswith(".py")), key=len)
    assert slave == script.replace(".py", "_slave.py")
    resources = ("instance.bin", "kernel-linux64.so", "model.json", "slavemodule.txt")
    expected = {f"resources/{name}" for name in resources}
    expected |= {"documentation/index.html", "documentation/licenses/license.txt", "model.png"}
    assert set(rest) == expected | {"modelDescription.xml", "binaries/linux64/RodDrop.so", script, slave}


def test_the_slave_imports_the_standard_library_and_pythonfmu_only():
    imported = set()
    # as of Python 3.8, the oldest for which pythonfmu's wrapper works
    for node in ast.walk(ast.parse(slave_source(), feature_version=(3, 8))):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            imported.add(node.module)
    assert {name.partition(".")[0] for name in imported} <= sys.stdlib_module_names | {"pythonfmu"}


def test_what_the_builder_says_is_passed_on(tmp_path, monkeypatch, fmus):
    monkeypatch.setattr(pythonfmu_target, "slave_source", lambda: b"raise RuntimeError('broken')\n")
    with pytest.raises(BuildError, match="RuntimeError: broken"):
        build_fmu("rod_drop", tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.full("takes long")
def test_an_fmu_for_both_platforms(tmp_path):
    fmu = build_fmu("rod_drop", tmp_path, platforms=("linux64", "win64"))
    names = zipfile.ZipFile(fmu).namelist()
    binaries = [name for name in names if name.startswith("binaries")]
    assert binaries == ["binaries/linux64/RodDrop.so", "binaries/win64/RodDrop.dll"]
    with zipfile.ZipFile(fmu) as archive:
        assert archive.read("resources/kernel-linux64.so").startswith(b"\x7fELF")
        assert archive.read("resources/kernel-win64.dll").startswith(b"MZ")
    assert fmu.stat().st_size < 2e6


# The functions before each test run in the clean process: they hold all that they use.


def process(fmu):
    import sys

    import fmpy

    fmpy.read_model_description(fmu)  # what fmpy itself imports late
    before = set(sys.modules)
    instance = Instance(fmu).start()
    instance.step(0.25)
    instance.get(instance.outputs)
    return [sorted(set(sys.modules) - before), instance["solver.steps"]]


def test_it_needs_the_standard_library_only(fmus, clean):
    modules, steps = clean(process, fmus["four_link_box"])
    assert steps > 0
    own = {name for name in modules if name.startswith("chain_impact")}
    assert len(own) == 2
    rest = {name.partition(".")[0] for name in modules} - own
    assert rest <= sys.stdlib_module_names | {"pythonfmu"}


def after_faults(fmu):
    """Refuse 100 times; the number of slaves and of references to their class before and after."""
    import gc
    import sys

    def references():
        slave = next(module for name, module in sys.modules.items() if name.endswith("_slave"))
        slaves = [one for one in gc.get_objects() if isinstance(one, slave.ChainImpact)]
        return len(slaves), sys.getrefcount(slave.ChainImpact)

    calls = [
        lambda i: i.start(**{"initial.y": -1.0}),
        lambda i: i.set({"contact.model": 99}),
        lambda i: i.fmu.getReal([9999]),
        lambda i: i.fmu.getBoolean([0]),
        lambda i: i.fmu.deSerializeFMUstate(b"nonsense"),
    ]
    for call in calls:
        refused(fmu, call)
    before = references()
    for _ in range(20):
        for call in calls:
            refused(fmu, call)
    return [before, references()]


def test_an_instance_can_be_freed_after_a_fault(fmus, clean):
    before, after = clean(after_faults, fmus["rod_drop"])
    assert before[0] == after[0] == 0
    assert after[1] - before[1] == 100  # the wrapper keeps one for each instance, with or without a fault


def without_a_log(fmu):
    import contextlib
    import io

    import fmpy

    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        try:
            fmpy.simulate_fmu(fmu, start_values={"initial.y": -1.0})
        except fmpy.fmi1.FMICallException as error:
            return [str(error), said.getvalue()]
    return ["", said.getvalue()]


def test_a_fault_is_seen_where_the_importer_does_not_log(fmus, clean):
    error, said = clean(without_a_log, fmus["rod_drop"])
    assert "status 4 (fatal)" in error
    beyond = "a contact point starts beyond a wall, or a joint beyond a stop"
    assert said == f"RodDrop: the simulation cannot start: {beyond}: point 0 at the wall y_min\n"


def with_damaged_start(fmu, folder):
    """A start that was edited by hand, in an FMU that is otherwise whole."""
    import contextlib
    import io
    import zipfile

    import fmpy

    damaged = f"{folder}/RodDrop.fmu"
    with zipfile.ZipFile(fmu) as whole, zipfile.ZipFile(damaged, "w") as other:
        for name in whole.namelist():
            content = whole.read(name)
            if name == "resources/instance.bin":
                content = content[:5000] + bytes([content[5000] ^ 1]) + content[5001:]
            other.writestr(name, content)
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        try:
            fmpy.simulate_fmu(damaged)
        except Exception as error:
            return [str(error), said.getvalue()]
    return ["", said.getvalue()]


def test_a_damaged_start_is_refused(fmus, clean, tmp_path):
    error, said = clean(with_damaged_start, fmus["rod_drop"], str(tmp_path))
    assert "instantiate" in error
    assert said == "RodDrop: the FMU's file resources/instance.bin is damaged\n"


def escaped(fmu):
    """What the wrapper takes for a printf format."""
    import sys

    Instance(fmu)
    slave = next(module for name, module in sys.modules.items() if name.endswith("_slave"))
    return repr(slave.SlaveError("100 % of #1"))


def test_percent_and_hash_are_escaped(fmus, clean):
    assert clean(escaped, fmus["rod_drop"]) == "100 %% of ##1"
