"""`chain-impact build`: build the FMU of a scene."""

from __future__ import annotations

import argparse
from pathlib import Path

from chain_impact.cli.completers import is_fmu
from chain_impact.cli.options import UsageError, Verbs, add_scene, add_verb
from chain_impact.cli.printing import say
from chain_impact.cli.progress_bar import progress
from chain_impact.cli.simulate import Canvas, simulate_and_tell
from chain_impact.cli.source import Source
from chain_impact.fmu.versions import FMI_2, FMI_3, VERSIONS
from chain_impact.scene.scene import load_scene
from chain_impact.system import HOST, PLATFORMS

FMU_KINDS = {
    ("pythonfmu", FMI_2): (
        "runs in Python programs, such as FMPy and PyFMI",
        "for Simulink, Dymola, OpenModelica and others: --target native",
    ),
    ("native", FMI_2): (
        "runs in tools with FMI 2.0, without Python",
        "for a step that ends at an impact: --fmi 3",
    ),
    ("native", FMI_3): ("runs in tools with FMI 3.0, without Python", "for tools with FMI 2.0 only: --fmi 2"),
}
"""(Value of --target, version of FMI) → two lines for the screen: where such an FMU runs, and the option for
an FMU that runs elsewhere."""


def add(verbs: Verbs) -> None:
    """Add the verb ``build``, with its arguments and options, to the parser of the command line."""
    build = add_verb(verbs, "build", "make the FMU of a scene", "pinned_arm --target native -o fmus")
    add_scene(build, "scene")
    build.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        type=Path,
        default=Path("build"),
        help="folder of the FMU; default: build",
    )
    build.add_argument(
        "--platform",
        type=_platforms,
        default=(HOST,),
        metavar="LIST",
        help=f"comma-separated, of: {', '.join(PLATFORMS)}; or all; default: this machine",
    )
    build.add_argument(
        "--target",
        choices=["pythonfmu", "native"],
        help="native: an FMU that needs no Python, the only target for FMI 3.0, macOS and ARM; default: "
        "pythonfmu for FMI 2.0 on Linux and Windows with x86-64, else native",
    )
    build.add_argument(
        "--fmi",
        type=int,
        choices=VERSIONS,
        default=FMI_2,
        help="version of FMI; 3 has event mode, in which a step ends at each impact; default: 2",
    )
    build.add_argument(
        "--simulate",
        action="store_true",
        help="run the FMU, and write a table (csv) and a picture to the same folder",
    )
    build.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Build the FMU of a scene; with ``--simulate``, also run the FMU, and write a table and a picture."""
    from chain_impact.fmu.build import TARGET, TARGETS, build_fmu

    if is_fmu(str(options.output)):
        folder_text = "it is a folder, and the FMU in it has the name of the scene"
        raise UsageError(f"-o {options.output} must not end in .fmu: {folder_text}")
    if options.output.is_file():
        raise UsageError(f"-o {options.output} is a file, must be a folder")
    # without --target, an FMU of FMI 3.0 is native, because no other target has this version
    target = options.target or (TARGET if options.fmi == FMI_2 else "native")
    if (target, options.fmi) not in FMU_KINDS:
        raise UsageError(f"--target {target} is for FMI 2.0 only; for --fmi {options.fmi}: --target native")
    for platform in {*options.platform} & ({*PLATFORMS} - {*TARGETS[target]}):
        raise UsageError(f"--platform {platform} needs --target native")
    scene = load_scene(options.source)
    with progress():
        fmu = build_fmu(scene, options.output, target=target, fmi=options.fmi, platforms=options.platform)
    say(f"FMU      {fmu}")
    for line in FMU_KINDS[target, options.fmi]:
        say(f"{'':9}{line}")
    if options.simulate:
        simulate_and_tell(Source(str(fmu)), Canvas(fmu.with_suffix(".png")), csv=fmu.with_suffix(".csv"))
    return 0


def _platforms(text: str) -> tuple[str, ...]:
    names = tuple(text.split(","))
    for name in names:
        if name not in PLATFORMS and text != "all":
            platforms_text = ", ".join(PLATFORMS)
            raise argparse.ArgumentTypeError(
                f"{name!r} is not a platform; must be of {platforms_text}, or all"
            )
    return names
