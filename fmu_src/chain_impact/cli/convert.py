"""`chain-impact convert`: convert a robot's file to a scene, or a scene to MJCF."""

from __future__ import annotations

import argparse

from chain_impact.cli.options import (
    SingleOption,
    UsageError,
    Verbs,
    add_repeated,
    add_verb,
    check_outputs,
    names_between_commas,
    path_with_suffix,
)
from chain_impact.cli.printing import say

SINGLE_OPTIONS = {
    "--plane": (
        "X,Y",
        "directions of the robot along which x and y of the scene point: --plane=x,z or --plane=-x,z; "
        "default: y up, x as near as possible to x of the robot",
    ),
    "--tip": (
        "FRAME",
        "site, body or link where the last link ends; default: the frame farthest from the last joint",
    ),
    "--keyframe": ("NAME", "keyframe of MJCF at which the robot starts, or none; default: the first"),
}
"""Option that can be given once → its metavariable and its help, in the order of the fields of
``ConversionChoices`` after the first one."""


def add(verbs: Verbs) -> None:
    """Add the verb ``convert``, with its arguments and options, to the parser of the command line."""
    verb = add_verb(
        verbs, "convert", "make a scene from URDF or MJCF, or MJCF from a scene", "robot.urdf -o scene.toml"
    )
    verb.add_argument("source", metavar="FILE", help="a planar chain in URDF or MJCF; or a scene, for MuJoCo")
    add_repeated(verb, "--joints", "NAMES", "only these joints move: elbow,wrist; default: all")
    for option, (metavar, help_text) in SINGLE_OPTIONS.items():
        verb.add_argument(option, action=SingleOption, metavar=metavar, help=help_text)
    verb.add_argument(
        "-o",
        dest="output",
        metavar="FILE",
        type=path_with_suffix(".toml", ".xml"),
        required=True,
        help="a scene (toml), or MJCF (xml)",
    )
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Convert a file, and print the remarks of the conversion, warnings first; return the exit code."""
    from chain_impact.conversion.convert import convert, remark_lines
    from chain_impact.conversion.planar import ConversionChoices

    choices = ConversionChoices(
        names_between_commas(*options.joints), options.plane, options.tip, options.keyframe
    )
    is_to_mjcf = options.output.suffix.lower() == ".xml"
    for option, chosen_names in zip(("--joints", *SINGLE_OPTIONS), choices, strict=True):
        if chosen_names and is_to_mjcf:
            raise UsageError(f"{option}: a scene has nothing to choose; it is for URDF and MJCF")
    check_outputs(options.output, inputs=[options.source])
    converted = convert(options.source, options.output, choices)
    say(f"{'MJCF' if is_to_mjcf else 'scene':9}{options.output}")
    for title, line in remark_lines(converted):
        say(f"{title:9}{line}")
    return 0
