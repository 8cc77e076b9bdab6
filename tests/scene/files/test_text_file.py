"""Text files from other programs: encodings, decimal commas, separators; scenes and tables alike."""

import itertools
import warnings

import numpy as np
import pytest

from chain_impact import SceneWarning, cli as command_line, load_scene, parse_scene
from chain_impact.recording.csv_file import read_csv
from chain_impact.scene.files.table_file import read_table
from chain_impact.scene.files.text_file import text_of
from chain_impact.studies.fit.scene_file import write_scene
from tests.helpers.tools.refusal import refusal

SCENE = """name = "Rod"
[[chain.links]]
length = 2.0
mass = 3.0
[initial]
angles = [0.5]
"""
TABLE = "time,point[0].x,point[0].y,point[1].x,point[1].y\n0,0,1,1,1\n0.1,0,0.95,1,0.95\n"
MODELS = "a scene file, a folder with scene.toml, or a model; `chain-impact info --list models` lists them"
READERS = {
    "scene": (load_scene, SCENE, f"cannot be read ({{}}); must be {MODELS}"),
    "recording": (lambda path: read_csv(path, {}), TABLE, "not a table of numbers: {}"),
    "measurements": (read_table, TABLE, "not a CSV table: {}"),
}
"""Name of a reader → the reader, a text for it, and its message on a bad file, with {} for the reason."""


@pytest.fixture(params=READERS)
def reader(request):
    return READERS[request.param]


# --- encodings ---------------------------------------------------------------------------------------------


def test_a_byte_order_mark_means_nothing(reader, tmp_path):
    read, text, _ = reader
    with_mark, without_mark = tmp_path / "with" / "file", tmp_path / "without" / "file"
    for path, encoding in ((with_mark, "utf-8-sig"), (without_mark, "utf-8")):
        path.parent.mkdir()
        path.write_text(text, encoding=encoding)
    assert text_of(with_mark) == text_of(without_mark) == text
    result, expected = read(with_mark), read(without_mark)
    if read is load_scene:
        assert result == expected == parse_scene("\ufeff" + SCENE, "text")
    elif read is read_table:
        assert (result.names, result.rows) == (expected.names, expected.rows)
    else:
        assert list(result.columns) == list(expected.columns)


def test_a_fitted_scene_can_be_like_a_file_with_a_mark(tmp_path):
    file_with_mark, path = tmp_path / "like.toml", tmp_path / "fitted.toml"
    file_with_mark.write_text(SCENE, encoding="utf-8-sig")
    write_scene(load_scene(file_with_mark).with_values({"initial.angle[1]": 0.75}), path, file_with_mark)
    assert path.read_text(encoding="utf-8") == SCENE.replace("[0.5]", "[0.75]")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_utf_16_is_refused(reader, tmp_path, encoding):
    read, text, form = reader
    path = tmp_path / "file"
    path.write_text(text, encoding=encoding)
    reason = "it is in UTF-16, or no text; must be text in UTF-8"
    assert refusal(read, path) == f"{path}: {form.format(reason)}"


def test_another_encoding_is_refused_with_the_line(reader, tmp_path):
    read, text, form = reader
    path = tmp_path / "file"
    first, rest = text.split("\n", 1)
    path.write_bytes(f"{first}\n# Länge\n{rest}".encode("latin-1"))
    reason = "line 2 has the byte 0xe4, which is no UTF-8; must be text in UTF-8"
    assert refusal(read, path) == f"{path}: {form.format(reason)}"


# --- decimal commas ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "number"),
    [
        (SCENE.replace("2.0", "2,5"), "2.5"),
        (SCENE.replace("2.0", "-0,25"), "-0.25"),
        ('name = "Rod"\nchain.links = [{length = 0,5, mass = 1.0}]\n', "0.5"),
    ],
)
def test_a_decimal_comma_is_pointed_at(text, number):
    message = refusal(parse_scene, text, "rod.toml")
    assert message.startswith("rod.toml: not valid TOML: ")
    assert message.endswith(f"; a number has a decimal point: {number}")


def test_no_other_fault_is_blamed_on_a_comma():
    for text in ("name = ", SCENE.replace("2.0", "2;5"), SCENE.replace("[0.5]", "[0.5")):
        assert "decimal point" not in refusal(parse_scene, text, "rod.toml")


@pytest.mark.parametrize("text", ["0,5", " 0,5 "])
def test_a_decimal_comma_in_a_value_is_pointed_at(text):
    message = refusal(load_scene("rod_drop").with_values, {"contact.restitution": text})
    requirement = "must be a finite number >= 0 and <= 1; a number has a decimal point: 0.5"
    assert message == f"RodDrop: contact.restitution = {text!r} {requirement}"
    message = refusal(load_scene("rod_drop").with_values, {"initial.angle[1]": "0,5 deg"})
    assert message.endswith('or text in degrees as "90 deg"; a number has a decimal point: 0.5')


@pytest.mark.parametrize(
    ("name", "text", "hint"),
    [
        ("contact.restitution", "0.1:0.9:9", "; one run has one value: `sweep --vary` takes several"),
        ("contact.restitution", "0.1, 0.5", "; one run has one value: `sweep --vary` takes several"),
        ("contact.restitution", "1,22,3", "; one run has one value: `sweep --vary` takes several"),
        ("contact.stiffness", "10^7", "; write 1e7"),
        ("initial.position", "0.1,-2", "; write [0.1,-2]"),
        ("initial.position", "here", "(position of the base)"),
    ],
)
def test_a_text_in_place_of_numbers_is_told_as_these(name, text, hint):
    assert refusal(load_scene("rod_drop").with_values, {name: text}).endswith(hint)


def test_on_the_command_line(capsys):
    assert command_line.main(["simulate", "rod_drop", "--set", "contact.restitution=0,5"]) == 2
    assert capsys.readouterr().err.endswith("a number has a decimal point: 0.5\n")


# --- separators --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mark", [";", "\t"])
@pytest.mark.parametrize("point", [".", ","])
def test_a_table_with_other_separators_is_read_as_one_with_commas(mark, point, tmp_path):
    rows = "\n".join([TABLE.splitlines()[0], "0,0,1,1,1", "", "1.5e-1,-.25,0.95,1,0.95"])
    usual_file, other_file = tmp_path / "usual.csv", tmp_path / "other.csv"
    usual_file.write_text(rows)
    head, *lines = rows.replace(",", mark).splitlines()
    other_file.write_text("\r\n".join([head, *(line.replace(".", point) for line in lines)]))
    columns, other_columns = (read_csv(path, {}).columns for path in (usual_file, other_file))
    assert columns.keys() == other_columns.keys()
    for name, column in columns.items():
        np.testing.assert_array_equal(other_columns[name], column)
    table, other_table = read_table(usual_file), read_table(other_file)
    assert (other_table.names, other_table.lines) == (table.names, table.lines)
    for row, name in itertools.product(range(2), table.names):
        assert other_table.number(row, name) == table.number(row, name)


def test_a_table_of_one_column_may_have_decimal_commas(tmp_path):
    path = tmp_path / "drop.csv"
    path.write_text("onset\n0,25\n1\n\n1,5\n")
    table = read_table(path)
    assert [table.number(row, "onset") for row in range(3)] == [0.25, 1.0, 1.5]


@pytest.mark.parametrize("name", ["recording", "measurements"])
def test_decimal_points_and_commas_in_one_table_are_refused(name, tmp_path):
    read, text, form = READERS[name]
    path = tmp_path / "table.csv"
    path.write_text(text.replace(",", ";") + "0,2;1;1;1;1,234\n")
    reason = "its numbers have decimal points and decimal commas; must have one of them"
    assert refusal(read, path) == f"{path}: {form.format(reason)}"


def test_a_unit_behind_a_number_is_pointed_at():
    for quantity, number in {"2.5e3 g  # heavy": "2.5", "70%": "0.7"}.items():
        assert f"; write {number}" in refusal(parse_scene, SCENE.replace("3.0", quantity), "rod.toml")


def test_a_decimal_comma_in_a_cell_is_pointed_at(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text('time,point[0].y\n"0,5",1\n')
    message = refusal(read_table(path).number, 0, "time")
    assert message.startswith(f"{path}: line 2: time = '0,5' must be a finite number")
    assert message.endswith("; a number has a decimal point: 0.5")


# --- values that are allowed, but may be mistakes -----------------------------------------------------------


def test_a_centre_of_mass_beyond_the_link_is_allowed_and_pointed_at():
    """A counterweight or a tool can lie there; a hint names it."""
    text = SCENE.replace("mass = 3.0", "mass = 3.0\ncenter_of_mass = 25")
    hint = "rod.toml: link[1].center_of_mass = 25 m lies beyond the end of the link, which is 2 m long"
    with pytest.warns(SceneWarning) as caught:
        scene = parse_scene(text, "rod.toml")
    assert [(str(warning.message), warning.filename) for warning in caught] == [(hint, __file__)]
    assert scene.chain.links[0].center_of_mass == 25.0
    with warnings.catch_warnings():
        warnings.simplefilter("error", SceneWarning)
        parse_scene(SCENE, "rod.toml").with_values({"link[1].center_of_mass": 2.0})


def test_a_step_longer_than_the_simulation_is_allowed_and_pointed_at():
    hint = "Rod: simulation.step_size = 5 s is longer than simulation.stop_time = 1 s"
    with pytest.warns(SceneWarning) as caught:
        scene = parse_scene(SCENE, "rod.toml").with_values({"simulation.step_size": 5.0})
    hint += ": there are two rows only, the start and the end"
    assert [(str(warning.message), warning.filename) for warning in caught] == [(hint, __file__)]
    assert scene.simulation.step_size == 5.0


def test_a_tab_behind_a_comma_and_marks_in_quotes_separate_no_columns(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("time,\tq\n0,\t1\n")
    assert read_table(path).names == ("time", "q")
    path.write_text('time,"q; rad"\n0,1\n')
    assert read_table(path).names == ("time", "q; rad")
