"""Features of the pythonfmu FMU only: the slave, and faults in its wrapper."""

# Tests: fmu/pythonfmu_target.py

import ast
import os
import re
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from chain_impact import load_scene
from chain_impact.fmu.build import build_fmu
from chain_impact.fmu.pythonfmu_target import slave_source
from chain_impact.fmu.references import REFERENCE_FILE
from chain_impact.fmu.scene_data import SCENE_DATA_FILE
from tests.fmu.clean import importing
from tests.fmu.importer import MESSAGES, Instance, refused
from tests.helpers.tools.planted_faults import spoiled
from tests.helpers.tools.zig import zig

in_python = {"kinds": "pythonfmu"}
FOLDER = Path(__file__).parent


@pytest.fixture
def path(all_fmus):
    return all_fmus["pythonfmu"]["rod_drop"]


def test_the_fmu_has_only_needed_files_and_a_script_for_its_values(path, tmp_path):
    names = zipfile.ZipFile(path).namelist()
    rest = [name for name in names if not name.startswith(("resources/pythonfmu/", "extra/"))]
    script, slave = sorted((name for name in rest if name.endswith(".py")), key=len)
    assert slave == script.replace(".py", "_slave.py")
    resources = ("kernel-linux64.so", "model.bin", "slavemodule.txt")
    expected = {f"resources/{name}" for name in resources}
    expected |= {REFERENCE_FILE, SCENE_DATA_FILE, "model.png"}
    expected |= {"documentation/index.html", "documentation/licenses/license.txt"}
    assert set(rest) == expected | {"modelDescription.xml", "binaries/linux64/RodDrop.so", script, slave}
    other_fmu = build_fmu(load_scene("rod_drop").with_values({"contact.stiffness": 2e8}), tmp_path)
    assert not {script, slave} & set(zipfile.ZipFile(other_fmu).namelist())


def test_the_slave_imports_the_standard_library_and_pythonfmu_only():
    imported = set()
    # Python 3.8 is the oldest version for pythonfmu's wrapper
    for node in ast.walk(ast.parse(slave_source(), feature_version=(3, 8))):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            imported.add(node.module)
    assert {name.partition(".")[0] for name in imported} <= sys.stdlib_module_names | {"pythonfmu"}


@pytest.mark.full("takes long")
def test_an_fmu_for_both_platforms(tmp_path):
    fmu = build_fmu("rod_drop", tmp_path, platforms=("linux64", "win64"))
    with zipfile.ZipFile(fmu) as archive:
        binaries = [name for name in archive.namelist() if name.startswith("binaries")]
        assert binaries == ["binaries/linux64/RodDrop.so", "binaries/win64/RodDrop.dll"]
        assert archive.read("resources/kernel-linux64.so").startswith(b"\x7fELF")
        assert archive.read("resources/kernel-win64.dll").startswith(b"MZ")
    assert fmu.stat().st_size < 2e6


@importing("four_link_box", **in_python)
def test_the_slave_needs_the_standard_library_only(fmu):
    import sys

    import fmpy

    fmpy.read_model_description(fmu)  # load the modules that fmpy imports late
    modules_before = set(sys.modules)
    instance = Instance(fmu).start()
    instance.step(0.25)
    instance.get(instance.outputs)
    modules = set(sys.modules) - modules_before
    own_modules = {name for name in modules if name.startswith("chain_impact")}
    assert len(own_modules) == 2
    assert {name.partition(".")[0] for name in modules - own_modules} <= sys.stdlib_module_names | {
        "pythonfmu"
    }
    assert instance["solver.steps"] > 0


@importing("rod_drop", **in_python)
def test_an_instance_can_be_freed_after_a_fault(fmu):
    """No slave of 20 refused instances stays in memory."""
    import gc
    import sys

    def references():
        slave = next(module for name, module in sys.modules.items() if name.endswith("_slave"))
        assert not [candidate for candidate in gc.get_objects() if isinstance(candidate, slave.ChainImpact)]
        return sys.getrefcount(slave.ChainImpact)

    calls = [
        lambda i: i.start(**{"initial.y": -1.0}),
        lambda i: i.set({"contact.model": 99}),
        lambda i: i.fmu.getReal([9999]),
        lambda i: i.fmu.getBoolean([0]),
        lambda i: i.fmu.deSerializeFMUstate(b"nonsense"),
    ]
    for call in calls:
        refused(fmu, call)
    count_before = references()
    for call in 4 * calls:
        refused(fmu, call)
    # the wrapper keeps one reference for each instance, with or without a fault
    assert references() - count_before == 20


def raised(fmu, values):
    """Return the text of fmpy's exception or "", and what is on standard error, as fmpy logs nothing here."""
    import contextlib
    import io

    import fmpy

    errors = io.StringIO()
    with contextlib.redirect_stderr(errors):
        try:
            fmpy.simulate_fmu(fmu, start_values=values)
        except Exception as error:
            return [str(error), errors.getvalue()]
    return ["", errors.getvalue()]


def test_a_fault_is_seen_where_the_importer_does_not_log(path, clean, tmp_path):
    error, printed = clean(raised, path, {"initial.y": -1.0})
    assert "status 4 (fatal)" in error
    reason = "a contact point starts beyond a wall, or a joint or slider beyond a stop"
    cause = f"the simulation cannot start: {reason}: point 0 at the wall y_min"
    assert printed == f"RodDrop: fmi2ExitInitializationMode: {cause}\n"


def damaged(name, content):
    """Return the content of a file of an FMU; in model.bin one bit is changed."""
    if name == "resources/model.bin":
        return content[:5000] + bytes([content[5000] ^ 1]) + content[5001:]
    return content


def described_anew(name, content):
    """Return the content of a file of an FMU; the model description has another GUID."""
    described = name == "modelDescription.xml"
    return re.sub(rb'(guid=")........', rb"\g<1>00000000", content) if described else content


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (damaged, "has a file model.bin that is damaged"),
        (described_anew, "fmuGUID 00000000-.* differs from that of this FMU"),
    ],
)
def test_an_fmu_that_is_not_whole_is_refused_at_once(path, clean_python, tmp_path, change, reason):
    """The process has not seen this FMU before."""
    spoilt = str(spoiled(path, tmp_path / "RodDrop.fmu", change))
    program = f"import sys; sys.path.insert(0, {str(FOLDER)!r}); from importer import *; Instance({spoilt!r})"
    process = subprocess.run([clean_python, "-I", "-c", program], capture_output=True, text=True, check=False)
    assert process.returncode != 0  # the wrapper of pythonfmu reads freed memory as the process ends
    assert re.search(f"^RodDrop: fmi2Instantiate: .*{reason}", process.stderr, re.M)
    assert "Failed to instantiate" in process.stderr


@importing("rod_drop", **in_python)
def test_an_instance_needs_a_name(fmu):
    import contextlib

    for name in ("", " \t"):
        MESSAGES.clear()
        with contextlib.suppress(Exception):
            Instance(fmu, name)
        assert MESSAGES[-1].endswith("fmi2Instantiate: the instance has no name")
    assert Instance(fmu, "x").start()["point[0].y"] > 0.0


@importing("rod_drop", **in_python)
def test_a_reason_is_a_format_for_the_wrapper_and_a_sentence_for_people(fmu):
    """The wrapper uses the message as a printf format."""
    import contextlib
    import io
    import sys

    Instance(fmu)
    slave = next(module for name, module in sys.modules.items() if name.endswith("_slave"))
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors):
        error = slave.SlaveError(reason="100 %% of ##1")
    assert [repr(error), errors.getvalue()] == ["100 %% of ##1", "RodDrop: 100 % of #1\n"]


# --- Ctrl-C ----------------------------------------------------------------------------------------------

LONG = """
instance = Instance(fmu).start(**{"solver.work_limit": 1e15})
print("right", flush=True)
try:
    instance.step(1e9)
except Exception as error:
    print(type(error).__name__, MESSAGES[-1].splitlines()[-1], flush=True)
instance.close()
print(Instance(fmu).start()["solver.status"])
"""


def test_ctrl_c_ends_a_long_step(all_fmus, clean_python):
    """The importer gets an error as for any other fault, and continues with other instances."""
    fmu = all_fmus["pythonfmu"]["simple_pendulum"]
    # a shell that starts a background job lets the job ignore Ctrl-C
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    lines = [
        heard,
        "import sys",
        f"sys.path.insert(0, {str(FOLDER)!r})",
        "from importer import *",
        f"fmu = {fmu!r}",
    ]
    command = [clean_python, "-I", "-c", "\n".join([*lines, LONG])]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "right\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (0, "FMICallException fmi2DoStep: interrupted\n0\n"), err


# --- the end of a process that has run the FMU, watched by guard.c -----------------------------------------


@pytest.fixture(scope="module")
def guard(tmp_path_factory):
    """Return the library to preload.

    At the end of a process pythonfmu's wrapper releases its state twice, the second time in freed memory,
    unless the slave has released it before.
    """
    folder = tmp_path_factory.mktemp("guard")
    zig(folder, "-shared", "-fPIC", FOLDER / "guard.c", "-o", folder / "guard.so")
    return folder / "guard.so"


FREED = "Instance(first_fmu).start().close()"
SEVERAL_INSTANCES = """
instances = [Instance(path).start() for path in (first_fmu, second_fmu) * 2]
instances.append(Instance(first_fmu, folder=instances[0].folder).start())
instances.pop(1).close()
Instance(second_fmu).start().close()
for instance in instances[1:]:
    instance.fmu.freeInstance()
instances[0].fmu.fmi2FreeInstance(instances[0].fmu.component)
"""
KEPT_INSTANCES = """
instances = [Instance(path).start() for path in (first_fmu, second_fmu)]
for instance in instances:
    shutil.rmtree(instance.folder)
"""
CYCLES = "for path in (first_fmu, second_fmu) * 5: fmpy.simulate_fmu(path, stop_time=0.01)"
REFUSED = 'assert "not > 0" in refused(first_fmu, Instance.start, lambda i: i.fmu.doStep(0.0, -1.0))'
RAISING = 'instance = Instance(first_fmu).start(); print("right", flush=True); sys.exit(1)'
NOT_RELEASED = f"{FREED}; import atexit; atexit._clear()"  # without the slave's release at exit


PROGRAMS = {"freed": FREED, "several": SEVERAL_INSTANCES, "kept": KEPT_INSTANCES}
PROGRAMS |= {"cycles": CYCLES, "refused": REFUSED}
PROGRAMS |= {"raising": RAISING, "not released": NOT_RELEASED}
CODES = {"raising": 1, "not released": -signal.SIGSEGV}


@pytest.mark.full("takes long")
@pytest.mark.parametrize("name", PROGRAMS)
def test_a_process_ends_well_and_the_guard_sees_where_it_does_not(guard, clean_python, all_fmus, name):
    first_fmu, second_fmu = (all_fmus["pythonfmu"][model] for model in ("rod_drop", "pinned_arm"))
    lines = ["import shutil, sys", f"sys.path.insert(0, {str(FOLDER)!r})", "from importer import *"]
    lines += [f"first_fmu, second_fmu = {first_fmu!r}, {second_fmu!r}", PROGRAMS[name], 'print("right")']
    # LD_PRELOAD separates names by spaces, and the name of a temporary folder may contain spaces
    environment = os.environ | {"LD_PRELOAD": f"./{guard.name}"}
    command = [clean_python, "-I", "-c", "\n".join(lines)]
    process = subprocess.run(
        command, cwd=guard.parent, env=environment, capture_output=True, text=True, check=False
    )
    assert (process.returncode, process.stdout) == (CODES.get(name, 0), "right\n"), process.stderr[-2000:]
