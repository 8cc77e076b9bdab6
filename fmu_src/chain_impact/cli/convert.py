"""`chain-impact convert`: a scene from a robot's file, and the other way."""

from __future__ import annotations

import argparse

from chain_impact.cli.options import (
    UsageError,
    Verbs,
    add_repeated,
    add_verb,
    check_outputs,
    ending,
    names_in,
)
from chain_impact.cli.progress import say


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    verb = add_verb(
        verbs, "convert", "make a scene from URDF or MJCF, or MJCF from a scene", "robot.urdf -o scene.toml"
    )
    verb.add_argument("source", metavar="FILE", help="a planar chain in URDF or MJCF; or a scene, for MuJoCo")
    add_repeated(verb, "--joints", "NAMES", "only these joints move: elbow,wrist; default: all")
    verb.add_argument(
        "-o",
        dest="output",
        metavar="FILE",
        type=ending(".toml", ".xml"),
        required=True,
        help="a scene (toml), or MJCF (xml)",
    )
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Convert, and say line by line what is left out."""
    from chain_impact.conversion.convert import convert

    joints, to_mjcf = names_in(*options.joints), options.output.suffix.lower() == ".xml"
    if joints and to_mjcf:
        raise UsageError("--joints: a scene has no joints to choose; it is for URDF and MJCF")
    check_outputs(options.output, inputs=[options.source])
    done = convert(options.source, options.output, joints)
    say(f"{'MJCF' if to_mjcf else 'scene':9}{options.output}")
    for title, lines in (("note", done.notes), ("left out", done.left_out)):
        for line in lines:
            say(f"{title:9}{line}")
    return 0
