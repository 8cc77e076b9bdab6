"""Faults that are planted in FMUs of ours, what is said of each, and what FMPy does with it.

Among them are those of the files that VDMCheck2 is tested with, each planted alone. Some of those files are
in accord with FMI 2.0.4, so they are no faults here: derivatives without an element Derivatives in an FMU for
co-simulation (2.2.8), min and max of a variable beyond those of its type (2.2.7), and no start value where
the limits leave out 0.
"""

import re
import zipfile

from chain_impact.fmu.validate import validation
from chain_impact.system import HOST, PLATFORMS

XML = "modelDescription.xml"
SUFFIX = PLATFORMS[HOST].suffix
BINARIES = {"fmi3": f"binaries/{PLATFORMS[HOST].fmi3}/RodDrop{SUFFIX}"}
BINARY = f"binaries/{HOST}/RodDrop{SUFFIX}"


def spoiled(fmu, target, change):
    """Write an FMU anew: ``change`` gets name and content of each file, and gives content or None."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            content = change(name, old.read(name))
            if content is not None:
                new.writestr(name, content)
    return target


def edited(*pairs):
    """A change of the model description: each pattern, which must be there, and what takes its place."""

    def change(name, content):
        text = content.decode() if name == XML else ""
        for pattern, new in pairs if text else ():
            text, count = re.subn(pattern, new, text, flags=re.DOTALL)
            assert count, pattern
        return text.encode() if text else content

    return change


def variable(name, pattern, new):
    """A change within the element of a variable of FMI 2.0 or 3.0."""
    return (
        rf'(name="{re.escape(name)}"[^\n]*(?:\n *<(?:Real|Integer|Enumeration)[^\n]*)?){pattern}',
        rf"\1{new}",
    )


def initial_unknown(attributes):
    """A change that gives the first initial unknown attributes."""
    pattern = r'<InitialUnknowns>(\s*)<Unknown index="(\d+)"'
    return pattern, rf'<InitialUnknowns>\1<Unknown index="\2" {attributes}'


def independent(name, without_start=False):
    """A change that makes a parameter an independent variable, with or without its start."""
    pattern = (
        rf'(name="{re.escape(name)}"[^\n]*)causality="parameter" variability="\w+" initial="exact"(>\s*<\w+)'
    )
    return (
        rf"{pattern}([^\n]*) start=\S+" if without_start else pattern,
        r'\1causality="independent" variability="continuous"\2' + (r"\3" if without_start else ""),
    )


FOUND, MISSED, BROKEN = "found", "not found", "ends in an error of its own"


def by_fmpy(path, *, names):
    """What FMPy does with a fault; ``names``: whether it looks at names, at 10 ms each."""
    from fmpy.model_description import ValidationError, read_model_description

    try:
        read_model_description(str(path), validate_variable_names=names, validate_model_structure=True)
    except ValidationError:
        return FOUND
    except Exception as error:
        return FOUND if type(error) is Exception else BROKEN  # it has no other class for its sentences
    return MISSED


def said(path, **options):
    found = validation(path, **options)
    return [str(finding) for finding in found.findings]


FMI2 = {
    "min > max": (
        [variable("link[1].mass", r'min="0.0"', 'min="9.0" max="8.0"')],
        "link[1].mass: min: min = 9 must not be above max = 8",
    ),
    "start out of range": (
        [variable("link[1].mass", r'min="0.0"', 'min="0.75"')],
        "link[1].mass: start: start = 0.5 is below min = 0.75",
    ),
    "start of an enumeration": (
        [variable("contact.model", r'start="7"', 'start="70"')],
        "contact.model: start: start = 70 is none of the values of the enumeration",
    ),
    "start other than the FMU's own": (
        [variable("link[1].mass", r'start="0.5"', 'start="0.51"')],
        "link[1].mass: start: start = 0.51, and the FMU itself starts with 0.5",
    ),
    "one reference of two parameters": (
        [variable("link[1].mass", r'valueReference="\d+"', 'valueReference="0"')],
        "link[1].mass: valueReference: valueReference = 0 is that of gravity.x, too, and both are given from",
    ),
    "one reference with two units": (
        [
            variable(f"point[0].{name}", r'valueReference="\d+"', 'valueReference="7000"')
            for name in ("x", "vx")
        ],
        "valueReference = 7000 is that of point[0].x, too, and their units differ, m/s and m",
    ),
    "a reference that the FMU does not know": (
        [variable("point[0].x", r'valueReference="\d+"', 'valueReference="99999"')],
        "point[0].x: cannot be read as 1 Real: fmi2GetReal fails: ",
    ),
    "an output that is not there": (
        [(r'<Outputs>(\s*)<Unknown index="\d+"', r'<Outputs>\1<Unknown index="99999"')],
        "ModelStructure/Outputs: index = '99999' must be an index from 1 to ",
    ),
    "a dependency on nothing": (
        [
            (
                r'<InitialUnknowns>(\s*)<Unknown index="(\d+)"',
                r'<InitialUnknowns>\1<Unknown index="\2" dependencies="0"',
            )
        ],
        "ModelStructure/InitialUnknowns, index ",
    ),
    "fewer kinds than dependencies": (
        [
            (
                r'<InitialUnknowns>(\s*)<Unknown index="(\d+)"',
                r'<InitialUnknowns>\1<Unknown index="\2" dependencies="1 2" dependenciesKind="dependent"',
            )
        ],
        "there are 2 dependencies, and 1 in dependenciesKind",
    ),
    "an output twice": (
        [(r'<Outputs>(\s*)(<Unknown index="\d+"[^\n]*)', r"<Outputs>\1\2\1\2")],
        " stands there 2 times",
    ),
    "an initial unknown too few": (
        [(r'<InitialUnknowns>\s*<Unknown index="\d+" ?/>', "<InitialUnknowns>")],
        "ModelStructure/InitialUnknowns: lacks ",
    ),
    "a type that is not defined": (
        [variable("link[1].mass", r'declaredType="Mass"', 'declaredType="Weight"')],
        "link[1].mass: declaredType: declaredType = 'Weight' must be defined in TypeDefinitions",
    ),
    "a unit that is not defined": (
        [variable("link[1].mass", r'unit="kg"', 'unit="stone"')],
        "link[1].mass: unit: unit = 'stone' must be defined in UnitDefinitions",
    ),
    "a display unit that is not defined": (
        [variable("link[1].mass", r'unit="kg"', 'unit="kg" displayUnit="stone"')],
        "displayUnit: displayUnit = 'stone' must be defined in UnitDefinitions for the unit 'kg'",
    ),
    "an output that leaves its range": (
        [variable("point[0].y", r'unit="m"', 'unit="m" max="-5.0"')],
        "point[0].y: is ",
    ),
    "a name twice": (
        [('"gravity.x"', '"gravity.y"')],
        'gravity.y: The variable name "gravity.y" (line ',
    ),
    "no start": (
        [variable("link[1].mass", r' start="0.5"', "")],
        'link[1].mass: Variable "link[1].mass" (line ',
    ),
    "a start of a calculated output": (
        [variable("point[0].x", r'unit="m"', 'unit="m" start="1.0"')],
        "point[0].x: The variable",
    ),
    "a constant parameter": (
        [variable("link[1].mass", '"fixed"', '"constant"')],
        "link[1].mass: The combination causality=",
    ),
    "an encoding that is not known": (
        [("encoding='UTF-8'", "encoding='abc'")],
        "modelDescription.xml: is no XML: unknown encoding: abc",
    ),
    "broken XML": ([("</ModelStructure>", "")], "modelDescription.xml: is no XML: "),
    "an attribute that is not in the schema": (
        [("<CoSimulation ", '<CoSimulation more="1" ')],
        "modelDescription.xml: ",
    ),
    "a version that is not known": (
        [('fmiVersion="2.0"', 'fmiVersion="1.0"')],
        "fmiVersion: fmiVersion = '1.0' must be one of 2.0, 3.0",
    ),
    "an output that is not listed": (
        [(r'<Outputs>\s*<Unknown index="\d+"[^\n]*', "<Outputs>")],
        "ModelStructure/Outputs: lacks point[0].x: it lists each output, and nothing else",
    ),
    "a parameter among the outputs": (
        [("<Outputs>", '<Outputs><Unknown index="1" />')],
        "ModelStructure/Outputs: must not have gravity.x: it lists each output",
    ),
    "a parameter among the initial unknowns": (
        [("<InitialUnknowns>", '<InitialUnknowns><Unknown index="1" />')],
        "ModelStructure/InitialUnknowns: must not have gravity.x: it lists each output, state and",
    ),
    "initial unknowns out of order": (
        [
            (
                r'<InitialUnknowns>(\s*<Unknown index="\d+" />)(\s*<Unknown index="\d+" />)',
                r"<InitialUnknowns>\2\1",
            )
        ],
        "ModelStructure/InitialUnknowns: ",
    ),
    "a derivative that is none": (
        [("<InitialUnknowns>", '<Derivatives><Unknown index="26" /></Derivatives><InitialUnknowns>')],
        "ModelStructure/Derivatives: must not have point[0].x: it lists variables with the",
    ),
    "a dependency twice": (
        [initial_unknown('dependencies="1 1"')],
        "dependencies: index = '1' stands there 2 times",
    ),
    "dependencies out of order": (
        [initial_unknown('dependencies="2 1"')],
        "dependencies: 1 must stand before 2",
    ),
    "a dependency that is not known": (
        [initial_unknown('dependencies="27"')],
        "dependencies: 27 is point[0].y, which is not known at the start",
    ),
    "an output that depends on an output": (
        [
            (r'(<Unknown index="27") dependencies=""', r'\1 dependencies="26"'),
            ("<InitialUnknowns>", '<Derivatives><Unknown index="29" /></Derivatives><InitialUnknowns>'),
        ],
        "dependencies: 26 is point[0].x, which is not an input, a parameter or a state",
    ),
    "a kind of dependency that is none at the start": (
        [initial_unknown('dependencies="1" dependenciesKind="fixed"')],
        "dependencies: dependenciesKind = 'fixed' is none at the start",
    ),
    "several settings at an instant": (
        [('name="gravity.x"', 'name="gravity.x" canHandleMultipleSetPerTimeInstant="true"')],
        "gravity.x: canHandleMultipleSetPerTimeInstant: canHandleMultipleSetPerTimeInstant is for inputs",
    ),
    "reinit without model exchange": (
        [variable("point[0].x", 'unit="m"', 'unit="m" reinit="true"')],
        "point[0].x: reinit: reinit is for model exchange only",
    ),
    "no kind of use": (
        [(r"<CoSimulation [^>]*>", "")],
        "CoSimulation: has none of CoSimulation, ModelExchange, ScheduledExecution",
    ),
    "an identifier that is none": (
        [('modelIdentifier="RodDrop"', 'modelIdentifier="Rod-Drop"')],
        "CoSimulation: modelIdentifier = 'Rod-Drop' must be a name of C",
    ),
    "two source files of one name": (
        [
            (
                r"(<CoSimulation [^>]*)/>",
                r'\1><SourceFiles><File name="a.c"/><File name="a.c"/></SourceFiles></CoSimulation>',
            )
        ],
        "CoSimulation/SourceFiles: name = 'a.c' stands there 2 times",
    ),
    "a type of another kind": (
        [variable("link[1].mass", '"Mass"', '"ContactModel"')],
        "declaredType = 'ContactModel' is a type of Enumeration, and the variable is of Real",
    ),
    "two types of one name": (
        [("<TypeDefinitions>", '<TypeDefinitions><SimpleType name="Mass"><Real /></SimpleType>')],
        "TypeDefinitions: name = 'Mass' stands there 2 times",
    ),
    "a type with the name of a variable": (
        [("<TypeDefinitions>", '<TypeDefinitions><SimpleType name="gravity.x"><Real /></SimpleType>')],
        "TypeDefinitions/gravity.x: a variable has the same name",
    ),
    "a type with min > max": (
        [
            (
                "<TypeDefinitions>",
                '<TypeDefinitions><SimpleType name="Odd"><Real min="2" max="1" /></SimpleType>',
            )
        ],
        "TypeDefinitions/Odd/min: min = 2 must not be above max = 1",
    ),
    "two items of one value": (
        [('value="2"', 'value="1"')],
        "TypeDefinitions/SimpleType/Enumeration: value = '1' stands there 2 times",
    ),
    "two items of one name": (
        [('<Item name="hertz"', '<Item name="hunt_crossley"')],
        "TypeDefinitions/SimpleType/Enumeration: name = 'hunt_crossley' stands there 2 times",
    ),
    "two units of one name": (
        [("<UnitDefinitions>", '<UnitDefinitions><Unit name="kg" />')],
        "UnitDefinitions: name = 'kg' stands there 2 times",
    ),
    "two display units of one name": (
        [('(<DisplayUnit name="deg"[^>]*>)', r"\1\1")],
        "UnitDefinitions/Unit: name = 'deg' stands there 2 times",
    ),
    "two log categories of one name": (
        [('(<Category name="[^>]*>)', r"\1\1")],
        "LogCategories: name = ",
    ),
    "two annotations of one tool": (
        [
            (
                "<ModelVariables>",
                '<VendorAnnotations><Tool name="a"><b/></Tool><Tool name="a"><b/></Tool></VendorAnnotations>'
                "<ModelVariables>",
            )
        ],
        "VendorAnnotations: name = 'a' stands there 2 times",
    ),
    "two annotations of one tool at a variable": (
        [
            (
                r'(name="gravity.x".*?)(</ScalarVariable>)',
                r'\1<Annotations><Tool name="a"/><Tool name="a"/></Annotations>\2',
            )
        ],
        "ModelVariables/ScalarVariable/Annotations: name = 'a' stands there 2 times",
    ),
    "an experiment that ends before it starts": (
        [('stopTime="2.0"', 'stopTime="-2.0"')],
        "DefaultExperiment: stopTime = -2 must not be before startTime = 0",
    ),
    "a step longer than the experiment": (
        [('stepSize="0.001"', 'stepSize="100"')],
        "DefaultExperiment: stepSize = 100 must be > 0 and fit into the experiment",
    ),
    "a continuous parameter": (
        [variable("link[1].mass", '"fixed" initial="exact"', '"continuous"')],
        'link[1].mass: Variable "link[1].mass" (line ',
    ),
    "an initial of an input": (
        [variable("gravity.x", 'causality="parameter" variability="fixed"', 'causality="input"')],
        "gravity.x: initial: initial must not be given where causality = 'input'",
    ),
    "a start of the independent variable": (
        [independent("gravity.x")],
        'has causality="independent" but provides a start value',
    ),
    "two independent variables": (
        [independent(name, without_start=True) for name in ("gravity.x", "gravity.y")],
        "ModelVariables: gravity.x, gravity.y are independent variables: there can be one",
    ),
    "an independent variable that is not Real": (
        [independent("contact.model", without_start=True)],
        "contact.model: causality: an independent variable must be Real, and this one is Enumeration",
    ),
    "one reference with two starts": (
        [
            (
                r'(name="point\[0\]\.[xy]" valueReference=")\d+("[^\n]*)"calculated"(>\s*<Real)',
                r'\g<1>25\2"exact"\3 start="0.0"',
            ),
            ('<Unknown index="2[67]" />', ""),
        ],
        "point[0].y: valueReference: valueReference = 25 is that of point[0].x, too, and both have a start",
    ),
    "one reference of a constant and a variable": (
        [
            (
                r'(name="point\[0\]\.x"[^\n]*)variability="continuous" initial="calculated"(>\s*<Real)',
                r'\1variability="constant"\2 start="0.0"',
            ),
            variable("point[0].y", r'valueReference="\d+"', 'valueReference="25"'),
            ('<Unknown index="26" />', ""),
        ],
        "point[0].y: valueReference: valueReference = 25 is that of point[0].x, too, and one is constant",
    ),
    "a name of no derivative": (
        [('"gravity.x"', '"der(-)"')],
        "der(-): name: 'der(-)' is no name of the naming ",
    ),
    "a name that begins with a digit": (
        [('"gravity.x"', '"123"')],
        "123: name: '123' is no name of the naming ",
    ),
    "a name with a wrong escape": (
        [('"gravity.x"', "\"'\\\\z'\"")],
        "is no name of the naming convention 'structured'",
    ),
}
FMI3 = {
    "min > max": FMI2["min > max"],
    "start out of range": FMI2["start out of range"],
    "start other than the FMU's own": FMI2["start other than the FMU's own"],
    "a unit that is not defined": FMI2["a unit that is not defined"],
    "one reference of two variables": (
        [variable("link[1].mass", r'valueReference="\d+"', 'valueReference="0"')],
        'link[1].mass: Variable "link[1].mass" ',
    ),
    "an array of another size": (
        [(r'(name="link.angle" [^\n]*\s*)<Dimension start="1"', r'\1<Dimension start="2"')],
        "link.angle: cannot be read as 2 Float64: fmi3GetFloat64 fails: ",
    ),
    "an array with too many starts": (
        [
            (
                r'(name="link.angle" [^\n]*)initial="calculated"([^>]*>\s*)<Dimension start="1"',
                r'\1initial="exact" start="0 0 0"\2<Dimension start="1"',
            ),
            ('<InitialUnknown valueReference="139" />', ""),
        ],
        "link.angle: start: there are 3 values, and the dimensions make 1",
    ),
    "a size by nothing": (
        [(r'(name="link.angle" [^\n]*\s*)<Dimension start="1"', r'\1<Dimension valueReference="99999"')],
        "link.angle: Dimension: valueReference = '99999' must be the value reference of a variable",
    ),
    "an output that is not there": (
        [(r'<Output valueReference="\d+"', '<Output valueReference="99999"')],
        "ModelStructure/Output: valueReference = '99999' must be the value reference of a variable",
    ),
    "a dependency on nothing": (
        [
            (
                r'<InitialUnknown valueReference="(\d+)"',
                r'<InitialUnknown valueReference="\1" dependencies="99999"',
            )
        ],
        "dependencies: '99999' must be the value reference of a variable",
    ),
    "a derivative of nothing": (
        [(r'derivative="136"', 'derivative="99999"')],
        "point.velocity: derivative: derivative = '99999' must be the value reference of a variable",
    ),
    "an output that is not listed": (
        [(r'<Output valueReference="\d+"[^\n]*', "")],
        "ModelStructure/Output: lacks ",
    ),
    "a parameter among the outputs": (
        [("<ModelStructure>", '<ModelStructure><Output valueReference="0" />')],
        "ModelStructure/Output: must not have gravity.x: it lists each output",
    ),
    "an initial unknown too few": (
        [(r'(<InitialUnknown valueReference="136" />)', "")],
        "ModelStructure/InitialUnknown: lacks point.position: it lists each output",
    ),
    "a parameter among the initial unknowns": (
        [(r'(<InitialUnknown valueReference="136" />)', r'\1<InitialUnknown valueReference="0" />')],
        "ModelStructure/InitialUnknown: must not have gravity.x: it lists each output",
    ),
    "a derivative that is none": (
        [
            (
                r"(<ModelStructure>.*?)(<InitialUnknown )",
                r'\1<ContinuousStateDerivative valueReference="136" />\2',
            )
        ],
        "ModelStructure/ContinuousStateDerivative: must not have point.position: it lists variables with",
    ),
    "a dependency that is not known": (
        [('<InitialUnknown valueReference="136"', r'\g<0> dependencies="137"')],
        "dependencies: 137 is point.velocity, which is not known at the start",
    ),
    "a size by a variable that is none": (
        [(r'(name="link.angle" [^\n]*\s*)<Dimension start="1"', r'\1<Dimension valueReference="134"')],
        "link.angle: Dimension: its size is solver.status, which must be UInt64, constant or a ",
    ),
    "no kind of use": FMI2["no kind of use"],
    "an identifier that is none": FMI2["an identifier that is none"],
    "a type of another kind": (
        [variable("link[1].mass", '"Mass"', '"ContactModel"')],
        "declaredType = 'ContactModel' is a type of Enumeration, and the variable is of Float64",
    ),
    "two types of one name": (
        [("<TypeDefinitions>", '<TypeDefinitions><Float64Type name="Mass" />')],
        "TypeDefinitions: name = 'Mass' stands there 2 times",
    ),
    "a type with the name of a variable": (
        [("<TypeDefinitions>", '<TypeDefinitions><Float64Type name="gravity.x" />')],
        "TypeDefinitions/gravity.x: a variable has the same name",
    ),
    "two items of one value": (
        [('value="2"', 'value="1"')],
        "TypeDefinitions/EnumerationType: value = '1' stands there 2 times",
    ),
    "two units of one name": FMI2["two units of one name"],
    "two log categories of one name": FMI2["two log categories of one name"],
    "an experiment that ends before it starts": FMI2["an experiment that ends before it starts"],
    "no independent variable": (
        [('causality="independent" variability="continuous"', 'causality="local" variability="continuous"')],
        "Exactly one independent variable must be defined",
    ),
    "a name of no derivative": FMI2["a name of no derivative"],
}
WHOLE = ["another GUID", "no binary", "a binary that is none", "no resources"]
"""Faults of the FMU as a whole, of each kind; FMPy finds none."""
FMPY_FINDS = {
    "native": [
        "fewer kinds than dependencies",
        "an initial unknown too few",
        "a type that is not defined",
        "a unit that is not defined",
        "a display unit that is not defined",
        "a name twice",
        "no start",
        "a start of a calculated output",
        "a constant parameter",
        "an attribute that is not in the schema",
        "a version that is not known",
        "an output that is not listed",
        "a parameter among the outputs",
        "a parameter among the initial unknowns",
        "a derivative that is none",
        "a continuous parameter",
        "a start of the independent variable",
        "an independent variable that is not Real",
        "a name of no derivative",
        "a name that begins with a digit",
    ],
    "fmi3": [
        "a unit that is not defined",
        "one reference of two variables",
        "a derivative of nothing",
        "an output that is not listed",
        "a parameter among the outputs",
        "an initial unknown too few",
        "a parameter among the initial unknowns",
        "a derivative that is none",
        "no independent variable",
        "a name of no derivative",
    ],
}
FMPY_BREAKS = {
    "native": ["an output that is not there", "an encoding that is not known", "broken XML"],
    "fmi3": [
        "a size by nothing",
        "an output that is not there",
        "a dependency on nothing",
        "a size by a variable that is none",
    ],
}
"""The names of the faults, by the kind of FMU; a test compares them with what FMPy does."""
