"""Faults that are planted in model descriptions of ours, and what is said of each."""

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
    "one reference, two parameters": (
        [variable("link[1].mass", r'valueReference="\d+"', 'valueReference="0"')],
        "link[1].mass: valueReference: valueReference = 0 is that of gravity.x, too, and both can be set",
    ),
    "one reference, two units": (
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
    "an index of the outputs": (
        [(r'<Outputs>(\s*)<Unknown index="\d+"', r'<Outputs>\1<Unknown index="99999"')],
        "ModelStructure/Outputs: index = '99999' must be an index from 1 to ",
    ),
    "a dependency": (
        [
            (
                r'<InitialUnknowns>(\s*)<Unknown index="(\d+)"',
                r'<InitialUnknowns>\1<Unknown index="\2" dependencies="0"',
            )
        ],
        "ModelStructure/InitialUnknowns, index ",
    ),
    "numbers of kinds": (
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
        "InitialUnknowns does not contain the expected set of variables",
    ),
    "a declared type": (
        [variable("link[1].mass", r'declaredType="Mass"', 'declaredType="Weight"')],
        "link[1].mass: declaredType: declaredType = 'Weight' must be defined in TypeDefinitions",
    ),
    "a unit": (
        [variable("link[1].mass", r'unit="kg"', 'unit="stone"')],
        "link[1].mass: unit: unit = 'stone' must be defined in UnitDefinitions",
    ),
    "a display unit": (
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
    "a start of an output": (
        [variable("point[0].x", r'unit="m"', 'unit="m" start="1.0"')],
        "point[0].x: The variable",
    ),
    "causality": (
        [variable("link[1].mass", '"fixed"', '"constant"')],
        "link[1].mass: The combination causality=",
    ),
    "XML": ([("</ModelStructure>", "")], "modelDescription.xml: is no XML: "),
    "schema": ([("<CoSimulation ", '<CoSimulation more="1" ')], "modelDescription.xml: "),
    "version": (
        [('fmiVersion="2.0"', 'fmiVersion="1.0"')],
        "fmiVersion: fmiVersion = '1.0' must be one of 2.0, 3.0",
    ),
}
FMI3 = {
    "min > max": FMI2["min > max"],
    "start out of range": FMI2["start out of range"],
    "start other than the FMU's own": FMI2["start other than the FMU's own"],
    "a unit": FMI2["a unit"],
    "one reference": (
        [variable("link[1].mass", r'valueReference="\d+"', 'valueReference="0"')],
        'link[1].mass: Variable "link[1].mass" ',
    ),
    "an array of another size": (
        [(r'(name="link.angle" [^\n]*\s*)<Dimension start="1"', r'\1<Dimension start="2"')],
        "link.angle: cannot be read as 2 Float64: fmi3GetFloat64 fails: ",
    ),
    "starts of an array": (
        [
            (
                r'(name="link.angle" [^\n]*)initial="calculated"([^>]*>\s*)<Dimension start="1"',
                r'\1initial="exact" start="0 0 0"\2<Dimension start="1"',
            )
        ],
        "link.angle: start: there are 3 values, and the dimensions make 1",
    ),
    "a dimension": (
        [(r'(name="link.angle" [^\n]*\s*)<Dimension start="1"', r'\1<Dimension valueReference="99999"')],
        "link.angle: Dimension: valueReference = '99999' must be the value reference of a variable",
    ),
    "an output that is not there": (
        [(r'<Output valueReference="\d+"', '<Output valueReference="99999"')],
        "ModelStructure/Output: valueReference = '99999' must be the value reference of a variable",
    ),
    "a dependency": (
        [
            (
                r'<InitialUnknown valueReference="(\d+)"',
                r'<InitialUnknown valueReference="\1" dependencies="99999"',
            )
        ],
        "dependencies: '99999' must be the value reference of a variable",
    ),
    "a derivative": (
        [(r'derivative="136"', 'derivative="99999"')],
        "point.velocity: derivative: derivative = '99999' must be the value reference of a variable",
    ),
}
