"""Faults planted in our FMUs: each is found with its place, and valid FMUs have none."""

# Tests: fmu/check_description.py, fmu/check_structure.py, fmu/check_variables.py, fmu/findings.py
# Tests: fmu/importer.py, fmu/check_run.py

import itertools
import re
import struct
import zipfile
from pathlib import Path

import pytest

from chain_impact.fmu import findings
from chain_impact.fmu.check_description import NAME_PATTERNS, description_findings
from chain_impact.fmu.importer import read_fmu
from chain_impact.fmu.validate import validate_and_run, validate_fmu
from chain_impact.scene.errors import SceneError
from chain_impact.system import HOST
from tests.fmu.standard import co_simulation_functions
from tests.helpers.tools.planted_faults import (
    BINARIES,
    BINARY,
    FAULTS,
    MISSED,
    REPORTED,
    SUFFIX,
    WHOLE,
    XML,
    by_fmpy,
    edited,
    finding_texts,
    spoiled,
)
from tests.helpers.tools.zig import zig
from tests.tiers import needs_compilers

# --- sound FMUs ------------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize("model", ["rod_drop", "kneed_leg", "controlled_arm"])
def test_an_fmu_of_ours_has_no_faults(fmus, model):
    report = validate_and_run(fmus[model])
    assert list(report.findings) == []
    assert [note.split(",")[0] for note in report.notes] == ["reference results: passed"]


# --- faults of each kind of FMU ---------------------------------------------------------------------------


@pytest.mark.full("more cases", but=["pythonfmu-another GUID", "pythonfmu-no binary"])
@pytest.mark.parametrize("fault", WHOLE)
def test_faults_of_the_whole_are_found(fmus, target, tmp_path, fault):
    binary = BINARIES.get(target, BINARY)

    def change(name, content):
        if fault == "another GUID" and name == XML:
            return re.sub(rb'((guid|instantiationToken)=")........', rb"\g<1>00000000", content)
        if name == binary and fault in ("no binary", "a binary that is none"):
            return None if fault == "no binary" else b"garbage"
        return None if fault == "no resources" and name.startswith("resources/") else content

    path = spoiled(fmus["rod_drop"], tmp_path / "x.fmu", change)
    (line,) = finding_texts(path)
    assert by_fmpy(path, names=False) == MISSED
    assert line.startswith(f"{binary}: ")
    sentence = {
        "another GUID": "Instantiate gives no instance: ",
        "no binary": f"so there is no binary for {HOST}: it has no folder binaries",
        "a binary that is none": "the loader fails: ",
        # pythonfmu's wrapper reads a file without testing whether the file exists
        "no resources": "crashes the process: " if target == "pythonfmu" else "gives no instance: ",
    }
    assert sentence[fault] in line


# --- faults of the model description ---------------------------------------------------------------------


def test_the_page_states_how_many_planted_faults_are_found():
    text = (Path(__file__).parents[2] / "docs" / "check_fmu.md").read_text("utf-8")
    stated = re.search(r"plant (\d+) .* and (\d+) .* FMPy finds (\d+) and (\d+)\.", text).groups()
    planted = [len(faults) + len(WHOLE) for faults in FAULTS.values()]
    by_fmpy = [sum(fault.by_fmpy == REPORTED for fault in faults.values()) for faults in FAULTS.values()]
    assert [*map(int, stated)] == [*planted, *by_fmpy]


CASES = [(version, name) for version, faults in FAULTS.items() for name in faults]


@pytest.mark.full("more cases", but=4)
@pytest.mark.parametrize(("version", "name"), CASES)
def test_a_planted_fault_is_found_with_its_place(all_fmus, quick_names, tmp_path, version, name):
    """Only the fault's own file is checked, except for faults that only a run shows."""
    fault, fmu = FAULTS[version][name], all_fmus["native" if version == "2" else "fmi3"]["rod_drop"]
    path = spoiled(fmu, tmp_path / "x.fmu", edited(*fault.pairs, alone=not fault.runs))
    lines = validate_fmu(path, run=fault.runs)
    assert any(fault.sentence in line for line in lines), lines
    assert all(re.match(r"(modelDescription\.xml|binaries/\S+): \S", line) for line in lines)
    assert all(len(line.split()) > 4 for line in lines)
    assert len(lines) == len(set(lines))
    assert by_fmpy(path, names=name.startswith("a name")) == fault.by_fmpy


DATA = ("constant", "fixed", "tunable")
VARIABILITIES = (*DATA, "discrete", "continuous")
SETTLED, GUESSED, ANY = ("exact",), ("calculated", "approx"), ("calculated", "exact", "approx")
# FMI 2.0.4, table in 2.2.7, and FMI 3.0, table 22: the permitted values of initial, default first
INITIALS = (
    {("parameter", variability): SETTLED for variability in DATA[1:]}
    | {("calculatedParameter", variability): GUESSED for variability in DATA[1:]}
    | {(kind, "constant"): SETTLED for kind in ("output", "local")}
    | {("local", variability): GUESSED for variability in DATA[1:]}
    | {(kind, variability): ANY for kind in ("output", "local") for variability in VARIABILITIES[3:]}
)
CAUSALITIES = ("parameter", "calculatedParameter", "input", "output", "local", "independent")
HEAD = (
    '<fmiModelDescription fmiVersion="{version}.0" modelName="m" {token}="0">'
    '<CoSimulation modelIdentifier="m"/>'
    "<ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>"
)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("causality", CAUSALITIES)
def test_causality_variability_initial_and_start_are_those_of_the_standard(tmp_path, version, causality):
    for variability, initial, start in itertools.product(VARIABILITIES, (None, *ANY), (True, False)):
        allowed_values = INITIALS.get((causality, variability), ())
        is_start_needed = allowed_values and (initial or allowed_values[0]) != "calculated"
        is_good = (initial is None or initial in allowed_values) and bool(allowed_values)
        if causality == "input" and variability in VARIABILITIES[3:]:
            is_good, is_start_needed = initial is None or (version == 3 and initial == "exact"), True
        if causality == "independent" and variability == "continuous":
            is_good, is_start_needed = initial is None, False
        attributes = f'name="v" valueReference="1" causality="{causality}" variability="{variability}"'
        attributes += f' initial="{initial}"' if initial else ""
        value = ' start="1"' if start else ""
        fmi2_variable = f"<ScalarVariable {attributes}><Real{value}/></ScalarVariable>"
        variable, token = (
            (fmi2_variable, "guid")
            if version == 2
            else (f"<Float64 {attributes}{value}/>", "instantiationToken")
        )
        text = HEAD.format(version=version, token=token, variables=variable)
        with zipfile.ZipFile(tmp_path / "x.fmu", "w") as fmu:
            fmu.writestr(XML, text)
        faults = [finding for finding in description_findings(tmp_path / "x.fmu") if finding.variable == "v"]
        assert bool(faults) == (not is_good or bool(is_start_needed) != start), (
            variability,
            initial,
            start,
            faults,
        )


def test_names_are_those_of_the_structured_convention():
    names = ["a", "_a1.b[1,2].c", "der(a)", "der(a[3].'x y',2)", "'motor #2'", r"'a\'b'", "'!#$%'.x[1]"]
    wrong_names = [
        "",
        "1",
        "a b",
        "ä",
        "a.",
        "a..b",
        "a[1]..b",
        "[1]",
        "a[1,]",
        "'",
        "'a",
        "''",
        r"'\z'",
        "der(a",
    ]
    wrong_names += ["der(a,b)"]
    assert [name for name in names + wrong_names if NAME_PATTERNS["structured"].fullmatch(name)] == names


@pytest.mark.parametrize("folder", ["terminalsAndIcons", "icons"])
def test_terminals_name_variables_that_are_there(native, tmp_path, folder):
    path = spoiled(native["rod_drop"], tmp_path / "x.fmu", lambda name, content: content)
    file = f"{folder}/terminalsAndIcons.xml"
    member = '<TerminalMemberVariable variableName="{}" memberName="{}" variableKind="signal"/>'
    stream = '<TerminalStreamMemberVariable inStreamVariableName="time" outStreamVariableName="gravity.y"/>'
    members = member.format("gravity.x", "x") + member.format("gravity.w", "x") + stream
    terminal = f'<Terminal name="t" matchingRule="plug">{members}</Terminal>'
    with zipfile.ZipFile(path, "a") as fmu:
        fmu.writestr(
            file, f"<fmiTerminalsAndIcons><Terminals>{terminal * 2}</Terminals></fmiTerminalsAndIcons>"
        )
    lines = validate_fmu(path)
    assert all(line.startswith(f"{file}: ") for line in lines)
    for sentence in (
        "Terminals: name = 't' is listed 2 times",
        "t: memberName = 'x' is listed 2 times",
        "TerminalMemberVariable: variableName = 'gravity.w' must be the name of a variable",
        "TerminalStreamMemberVariable: inStreamVariableName = 'time' must be the name of a variable",
    ):
        assert any(line.endswith(sentence) for line in lines), lines


def test_terminals_that_are_no_xml_are_told_with_their_file(native, tmp_path):
    path = spoiled(native["rod_drop"], tmp_path / "x.fmu", lambda name, content: content)
    with zipfile.ZipFile(path, "a") as fmu:
        fmu.writestr("icons/terminalsAndIcons.xml", "<Terminals>")
    (line,) = validate_fmu(path)
    assert line.startswith("icons/terminalsAndIcons.xml: is no XML: ")


@pytest.mark.parametrize(
    "names", ["min > max, a continuous parameter", "an output that is not there, two units of one name"]
)
def test_a_fault_does_not_hide_another(native, tmp_path, names):
    """FMPy stops at the first of some faults, and crashes at others."""
    faults = [FAULTS["2"][name] for name in names.split(", ")]
    change = edited(*(pair for fault in faults for pair in fault.pairs))
    lines = validate_fmu(spoiled(native["rod_drop"], tmp_path / "x.fmu", change))
    assert all(any(fault.sentence in line for line in lines) for fault in faults), lines


def test_the_cause_is_listed_before_its_consequences(native, tmp_path):
    """A variable of an unknown causality is no output, so other findings follow from it."""
    change = edited(('causality="output"', 'causality="outgoing"'), alone=True)
    first, *other_findings = validate_fmu(spoiled(native["rod_drop"], tmp_path / "x.fmu", change))
    assert "outgoing" in first
    assert any("ModelStructure" in line for line in other_findings)


def test_findings_that_differ_only_in_the_variable_share_a_line(native, tmp_path):
    change = edited(('(<Real declaredType="Length" unit=")m"', r'\1parsec"'), alone=True)
    all_findings = description_findings(spoiled(native["rod_drop"], tmp_path / "x.fmu", change))
    assert len(all_findings) > findings.MOST_ALIKE_FINDINGS
    (line,) = findings.finding_lines(all_findings)
    names = [finding.variable for finding in all_findings]
    name_count = findings.NAMED_VARIABLES
    assert f"{', '.join(names[:name_count])} and {len(names) - name_count} more: The unit" in line
    few_findings = all_findings[: findings.MOST_ALIKE_FINDINGS]
    assert findings.finding_lines(few_findings) == [str(finding) for finding in few_findings]


def test_an_alias_is_no_fault(native, tmp_path):
    """In FMI 2.0 two outputs may have one value reference: each is an alias of the other."""

    def change(name, content):
        if name != XML:
            return content
        text = content.decode()
        reference = re.search(r'name="point\[0\]\.x" valueReference="(\d+)"', text)[1]
        return re.sub(r'(name="point\[1\]\.x" valueReference=")\d+', rf"\g<1>{reference}", text).encode()

    lines = finding_texts(spoiled(native["rod_drop"], tmp_path / "x.fmu", change))
    assert not [line for line in lines if "valueReference" in line]


# --- the zip ---------------------------------------------------------------------------------------------


def test_a_bomb_is_refused_by_its_declared_sizes(native, tmp_path, monkeypatch):
    path = spoiled(native["rod_drop"], tmp_path / "x.fmu", lambda name, content: content)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as fmu:
        fmu.writestr("extra/bomb.csv", bytes(1000))
    raw = path.read_bytes()
    # the central directory declares the unpacked size
    at = raw.rindex(b"extra/bomb.csv") - 46
    assert raw[at : at + 4] == b"PK\1\2"
    path.write_bytes(raw[: at + 24] + struct.pack("<I", 4_294_000_000) + raw[at + 28 :])
    (line,) = finding_texts(path)
    assert line.startswith("extra/bomb.csv: has 4.29 GB, and the whole FMU 4.29 GB")
    assert validate_fmu(path) == [line]
    with pytest.raises(SceneError, match=r"x\.fmu: not a readable FMU: extra/bomb\.csv: has 4\.29 GB"):
        read_fmu(path)
    monkeypatch.setattr(findings, "LARGEST_SUM", 10**10)
    assert findings.archive_findings(path) == []


@pytest.mark.parametrize(
    "name",
    ["../x", "extra/../../x", "/etc/x", "C:/x", "resources\\x"],
    ids=["up", "inner", "root", "drive", "slash"],
)
def test_a_path_that_leaves_the_folder_is_refused(native, tmp_path, name):
    path = spoiled(native["rod_drop"], tmp_path / "x.fmu", lambda name, content: content)
    with zipfile.ZipFile(path, "a") as fmu:
        fmu.writestr(name, b"")
    (line,) = finding_texts(path)
    assert line.startswith(f"{name}: the path ")


def test_an_fmu_for_scheduled_execution_is_not_run(fmi3, tmp_path):
    change = edited(
        (r"<CoSimulation modelIdentifier=(\S+)[^>]*>", r"<ScheduledExecution modelIdentifier=\1/>")
    )
    path = spoiled(fmi3["rod_drop"], tmp_path / "x.fmu", change)
    (note,) = validate_and_run(path).notes
    assert note.startswith("not run: ")
    assert validate_fmu(path, run=True) == [*validate_fmu(path), note]


# --- binaries that crash, that do not come back, and that do not restore their state -----------------------

COUNTER = """
#include <stddef.h>
static int steps;
static int instance;
void *fmi2Instantiate(void) { return &instance; }
int fmi2DoStep(void *c, double time, double step, int last) { steps += 1; return 0; }
int fmi2GetReal(void *c, const unsigned vr[], size_t n, double values[]) {
    for (size_t i = 0; i < n; i++) values[i] = steps;
    return 0;
}
"""


@pytest.fixture
def faults_of(native, tmp_path):
    """Return a function that finds the faults of an FMU with the given C source.

    Functions of the standard that the source does not define return ``status``.
    """

    def faults_of(source, status, **options):
        names = (name for name in co_simulation_functions() if f"{name}(" not in source)
        other_functions = (f"int {name}(void) {{ return {status}; }}\n" for name in names)
        (tmp_path / "fmu.c").write_text(source + "".join(other_functions))
        zig(tmp_path, "-shared", "-fPIC", "fmu.c", "-o", f"fmu{SUFFIX}")
        binary = (tmp_path / f"fmu{SUFFIX}").read_bytes()
        path = spoiled(
            native["rod_drop"], tmp_path / "x.fmu", lambda n, content: binary if n == BINARY else content
        )
        return finding_texts(path, **options)

    return faults_of


@needs_compilers
@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("abort();", "fmi2Instantiate crashes the process: SIGABRT"),
        ("exit(7);", "fmi2Instantiate ends the process, exit code 7"),
        ("for (volatile int i = 0;; i = !i) {}", "fmi2Instantiate did not return within 3 s"),
    ],
)
def test_a_binary_that_does_not_come_back_is_found(faults_of, body, sentence):
    source = f"#include <stdlib.h>\nvoid *fmi2Instantiate(void) {{ {body} }}\n"
    assert faults_of(source, 3, timeout=3.0 if "for" in body else 60.0) == [f"{BINARY}: {sentence}"]


@needs_compilers
def test_a_state_that_does_not_restore_is_found(faults_of):
    """Each value is the number of steps, which no restored state resets."""
    restored = "is 2 after a step, and 3 after the same step from the restored state (SetFMUState)"
    lines = faults_of(COUNTER, 0)
    assert any(line.endswith(restored) for line in lines), lines
