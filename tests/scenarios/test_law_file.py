"""A user's own contact law: equal impacts in simulate() and in an FMU, and refused laws."""

import functools
import math
import re
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from chain_impact import (
    BuildError,
    SceneError,
    SimulationError,
    build_fmu,
    cli,
    load_scene,
    simulate,
    with_law,
)
from chain_impact.compilation.folders import base_folder
from chain_impact.kernel.forces.laws import CONTACT_LAWS, LAW_COUNT
from chain_impact.kernel.forces.user_law import LAW_ARGUMENTS
from chain_impact.kernel.status import NOT_FINITE
from chain_impact.scene.errors import SceneWarning
from chain_impact.scene.files.models import models_folder
from chain_impact.scene.scene import parse_scene, scene_to_dict, with_values
from chain_impact.user_laws.law_file import source_of
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.scenes.problems import ball, own_law, struck_ball
from tests.tiers import needs_compilers

# a single law for all simulating tests, because each law needs a compilation; the restitution selects the
# formula
DAMPED = f"""
import math

LOSS = 0.3

def root(x):
    return math.sqrt(x)

def damped({", ".join(LAW_ARGUMENTS)}):
    '''Hunt and Crossley, for a fixed loss.'''
    if restitution == 0.375:
        wrong = (stiffness - 2e5) ** 2 + (exponent - 1.25) ** 2
        wrong += (impact_speed - 1.0) ** 2 + (effective_mass - 2.0) ** 2
        return 1e6 * penetration + (0.0 if wrong < 1e-18 else 1e9)
    if restitution == 0.8:
        return 1e6 * penetration + 4e3 * rate
    if restitution == 0.9:
        return rate * float("nan")
    return stiffness * penetration * root(penetration) * (1.0 + LOSS * rate / impact_speed)
"""


@pytest.fixture
def law(tmp_path):
    """Write a file with a law; return its path."""

    def write(text, name="damped"):
        path = tmp_path / f"{name}.py"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def with_file(scene, path):
    return with_values(scene, {("contact", "law_file"): path, ("contact", "model"): Path(path).stem})


def refusal(law, text, name="damped"):
    """Return the message with which a scene refuses a file, without the name of scene and file."""
    path = law(text, name)
    with pytest.raises(SceneError) as caught:
        with_file(load_scene("rod_drop"), path)
    message = str(caught.value)
    assert message.startswith("RodDrop: contact.law_file = '")
    return message.split(".py' ", 1)[-1]


# --- what it does ------------------------------------------------------------------------------------------


@needs_compilers
def test_an_impact_is_that_of_the_same_law_in_the_registry(law):
    """λ = 0.3 is the damping of Hunt and Crossley for e = 0.8."""
    scene, exact = struck_ball(damping_factor=0.3)
    for method in ("explicit", "implicit"):
        (impact,) = simulate(with_file(scene, law(DAMPED)), method=method).impacts
        for name in ("max_penetration", "peak_force", "separation_speed"):
            assert impact[name] == pytest.approx(getattr(exact, name), rel=3e-8)


def test_a_law_that_is_not_that_of_the_scene_is_pointed_at(law, tmp_path):
    scene = tmp_path / "scene.toml"
    text = (models_folder() / "rod_drop" / "scene.toml").read_text(encoding="utf-8")
    scene.write_text(text.replace("[contact]", f"[contact]\nlaw_file = '{law(DAMPED)}'"), encoding="utf-8")
    with pytest.warns(SceneWarning) as caught:
        loaded = load_scene(scene)
    hint = 'contact.law_file gives the law damped, but contact.model is "zhang_sharf"'
    assert [str(warning.message) for warning in caught] == [f"{scene}: {hint}"]
    assert loaded.with_values({"contact.model": "damped"}).contact.model == "damped"


@needs_compilers
@pytest.mark.parametrize("change", [lambda path: path.write_text("# another"), Path.unlink])
def test_a_result_is_of_the_law_that_it_was_simulated_with(law, change):
    path = Path(law(DAMPED))
    result = simulate(with_file(struck_ball()[0], str(path)), output_step=math.inf)
    change(path)
    assert result["impact.count"].tolist() == [0, 1]


@pytest.mark.full("takes long")
def test_a_users_law_gets_all_quantities_and_may_use_them_freely(law):
    """The law pushes hard if an argument is wrong; for e = 0.8 it pulls; for e = 0.9 it returns NaN."""
    scene = ball(1e-3, mass=2.0, stiffness=2e5, exponent=1.25, restitution=0.375)
    scene = with_file(scene, law(DAMPED))
    (impact,) = simulate(scene).impacts
    assert impact["separation_speed"] == pytest.approx(1.0, rel=1e-7)
    assert impact["max_penetration"] == pytest.approx(math.sqrt(2.0 / 1e6), rel=1e-7)

    result = simulate(with_values(scene, {("contact", "restitution"): 0.8}))
    assert (result.outputs["force"] >= 0.0).all()
    assert 0.0 < result.impacts["separation_speed"][0] < 0.5
    assert np.ptp(result.energy["total"] + result.energy["dissipated"]) < 1e-7

    with pytest.raises(SimulationError) as caught:
        simulate(with_values(scene, {("contact", "restitution"): 0.9}))
    assert caught.value.status == NOT_FINITE


# --- scene and FMU -----------------------------------------------------------------------------------------


def test_the_file_is_sought_beside_the_scene(law, tmp_path):
    law(DAMPED)
    text = 'name = "Own"\nchain.links = [{length = 1.0, mass = 1.0}]\ninitial.angles = [0.5]\n'
    text += '[contact]\nlaw_file = "damped.py"\nmodel = "damped"'
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    scene = load_scene(path)
    assert scene.contact.law_file == str(tmp_path / "damped.py")
    assert scene_to_dict(with_values(scene, {("solver", "tolerance"): 1e-6}))["contact"]["model"] == "damped"
    with pytest.raises(SceneError, match=r"contact\.law_file = 'damped\.py' cannot be read \(No such file"):
        parse_scene(text, "elsewhere/scene.toml")


@pytest.mark.full("takes long")
def test_a_users_law_is_the_last_choice_of_the_enumeration(law):
    scene = with_file(load_scene("rod_drop"), law(DAMPED))
    model = next(v for v in PreparedScene(scene).variables if v.name == "contact.model")
    assert len(model.items) == LAW_COUNT + 1
    assert (model.items[-1].name, model.items[-1].description) == (
        "damped",
        "Hunt and Crossley, for a fixed loss.",
    )
    # the laws of the registry can still be chosen
    other = with_values(scene, {("contact", "model"): "hertz"})
    assert simulate(other).impacts["separation_speed"][0] > simulate(scene).impacts["separation_speed"][0]


@pytest.mark.full("takes long")
def test_an_fmu_carries_it(law, tmp_path):
    path = law(DAMPED)
    scene = with_file(load_scene("rod_drop"), path)
    expected = simulate(scene, stop_time=0.9).energy["total"]
    fmu = build_fmu(scene, tmp_path)
    Path(path).unlink()
    rows = fmpy.simulate_fmu(str(fmu), stop_time=0.9, output=["energy.total", "impact.last_speed"])
    np.testing.assert_allclose(rows["energy.total"], expected, rtol=1e-12)
    kinds = {kind.name: kind for kind in fmpy.read_model_description(str(fmu)).typeDefinitions}
    assert [item.name for item in kinds["ContactModel"].items] == [*CONTACT_LAWS, "damped"]
    library = next(kernels(fmu))
    assert str(tmp_path).encode() not in library


def kernels(fmu):
    """Yield the compiled kernels in an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        yield from (archive.read(name) for name in archive.namelist() if "kernel-" in name)


@pytest.mark.full("takes long")
def test_a_file_that_has_changed_is_another_law(tmp_path):
    file, peaks = tmp_path / "mine.py", []
    text = source_of(own_law())
    for version in (text, text.replace("return stiffness", "return 2.0 * stiffness")):
        file.write_text(version)
        scene = with_file(load_scene("rod_drop"), str(file))
        peaks.append(simulate(scene, stop_time=0.9).impacts["peak_force"][0])
    assert peaks[1] > 1.2 * peaks[0]


@pytest.mark.full("takes long")
def test_a_function_of_python_is_a_law():
    scene, exact = struck_ball(damping_factor=0.2)
    (impact,) = simulate(with_law(scene, own_law())).impacts
    for name in ("max_penetration", "peak_force", "separation_speed"):
        assert impact[name] == pytest.approx(getattr(exact, name), rel=1e-7)


def test_a_function_without_source_is_refused():
    with pytest.raises(SceneError, match=r"RodDrop: the contact law <built-in function pow> has no source"):
        with_law(load_scene("rod_drop"), math.pow)


def hertz(penetration):
    return 1e6 * penetration


def takes_another_argument(depth):
    return 1e6 * depth


@pytest.mark.full("more cases", but="lambda")
@pytest.mark.parametrize(
    ("law", "reason"),
    [
        (lambda penetration: 1e6 * penetration, "has no name: give a named function, written with def"),
        (functools.partial(hertz, 1.0), "has no name: give a named function, written with def"),
        (hertz, "must have the name of its law, and this must not be hertz, which is a contact law already"),
        (takes_another_argument, "takes_another_argument takes depth; it can take penetration, "),
    ],
    ids=["lambda", "partial", "a name that is taken", "an argument"],
)
def test_a_function_that_cannot_be_a_law_is_told_why(law, reason):
    """The message does not name the folder in which the law would be stored."""
    with pytest.raises(SceneError) as caught:
        with_law(load_scene("rod_drop"), law)
    assert f" {reason}" in str(caught.value)
    assert str(base_folder()) not in str(caught.value)


# --- what is refused ---------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=7)
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("def other(rate):\n    return 1.0", "must define the function damped"),
        ("def damped(rate:\n    return 1.0", "is not valid Python: "),
        ("def damped(depth):\n    return 1.0", f"damped takes depth; it can take {', '.join(LAW_ARGUMENTS)}"),
        ("def damped(*rate):\n    return 1.0", f"damped takes rate; it can take {', '.join(LAW_ARGUMENTS)}"),
        (
            "import numpy\ndef damped(rate):\n    return 1.0",
            "imports numpy in line 1; a law can import math only",
        ),
        ("def damped(rate):\n    raise ValueError", "raises in line 2; a law has to return a force"),
        ("def damped(rate):\n    a = [rate]\n    return a[0]", "makes arrays or lists in line 2; a law can"),
        (
            "def damped(rate):\n    return 'a' + rate",
            "has 'a' in line 2; a law's file can have: import math, ",
        ),
    ],
)
def test_a_bad_file_is_refused_with_the_scene(law, text, message):
    assert refusal(law, text).startswith(message)


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize(
    ("name", "reason"),
    [("my-law", ": letters, "), ("zhang_sharf", ", and this must not be zh"), ("Stoß", ": l")],
)
def test_a_bad_name_is_refused_with_the_scene(law, name, reason):
    assert refusal(law, DAMPED, name).startswith(f"must have the name of its law{reason}")


@pytest.mark.full("takes long")
def test_a_model_that_is_not_the_files_is_refused(law):
    changes = {("contact", "law_file"): law(DAMPED), ("contact", "model"): "damp"}
    refused = r"contact\.model = 'damp' must be one of .*, \"damped\"; the nearest is damped$"
    with pytest.raises(SceneError, match=refused):
        with_values(load_scene("rod_drop"), changes)


@pytest.mark.parametrize(("model", "file"), [("bumper", "law"), ("law", "law"), ("bumper", "flores")])
def test_a_function_that_has_not_the_files_name_is_named(tmp_path, model, file):
    (tmp_path / f"{file}.py").write_text("def bumper(rate):\n    return rate\n", encoding="utf-8")
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'name = "Own"\nchain.links = [{length = 1.0, mass = 1.0}]\ninitial.angles = [0.5]\n'
        f'initial.position = [0.0, 1.0]\n[contact]\nlaw_file = "{file}.py"\nmodel = "{model}"\n',
        encoding="utf-8",
    )
    with pytest.raises(SceneError) as caught:
        load_scene(scene)
    hint = f"; {file}.py defines bumper: file, function and model must have one name"
    assert str(caught.value).count(hint) == 1


@needs_compilers
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("def damped(rate):\n    return stiffnes * rate", "does not compile: NameError: name 'stiffnes'"),
        ("def damped(rate):\n    return rate + (1.0, 2.0)", "does not compile: .* (line 2)"),
        ("def damped(rate):\n    force = rate", "must return a number, not none"),
        ("LOSS = 1 / 0\ndef damped(rate):\n    return LOSS", "cannot be run: ZeroDivisionError"),
    ],
)
def test_a_law_that_does_not_compile_is_refused_by_the_build(law, text, message, capsys):
    path = law(text)
    pattern = re.escape(f"{path} {message}").replace(r"\.\*", ".*")
    with pytest.raises(BuildError, match=pattern):
        simulate(with_file(load_scene("rod_drop"), path))


@pytest.mark.full("takes long")
def test_the_command_line_says_in_one_line_what_is_wrong(law, tmp_path, capsys):
    path = law("def damped(rate):\n    return stiffnes * rate")
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'name = "Own"\nchain.links = [{length = 1.0, mass = 1.0}]\ninitial.angles = [0.5]\n'
        "initial.position = [0.0, 1.0]\nbox.y_min = 0.0\n"
        '[contact]\nlaw_file = "damped.py"\nmodel = "damped"\n',
        encoding="utf-8",
    )
    assert cli.main(["simulate", str(scene)]) != 0
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{path} does not compile: NameError" in line
