"""chain-impact: the impact dynamics of planar robotic chains, in Python, on the command line and as FMUs.

A public name is imported from its module when it is used for the first time, since importing all modules
takes long.
"""

from importlib import import_module
from typing import Any

_MODULES = {
    "compilation.errors": ("BuildError",),
    "extras": ("MissingExtraError",),
    "fmu.build": ("build_fmu",),
    "fmu.run": ("record_fmu",),
    "fmu.validate": ("validate_fmu",),
    "kernel.forces.contact_law": ("ContactLaw",),
    "kernel.forces.laws": ("CONTACT_LAWS",),
    "results.animation": ("AnimationError",),
    "recording.impacts": ("IMPACT_DTYPE", "impacts_of"),
    "pages.explore": ("explore",),
    "results.ranking": ("Ranking",),
    "recording.recording": ("Recording",),
    "results.result": ("Result",),
    "recording.sensitivity": ("Sensitivities",),
    "recording.stick_slip": ("STICK_SLIP_DTYPE",),
    "scene.files.models": ("model_names",),
    "scene.errors": ("SceneError", "SceneWarning", "UnknownNameError"),
    "scene.scene": ("Scene", "load_scene", "parse_scene", "with_values"),
    "scene.stiffness": ("sphere_plane_stiffness",),
    "simulation.chain": ("Chain",),
    "simulation.derivatives": ("Differentiated", "DifferentiatedRun"),
    "simulation.errors": ("RunError", "SimulationError"),
    "simulation.given_inputs": ("Signal",),
    "simulation.simulate": ("simulate", "with_law"),
    "studies.animate": ("animate", "record_slowly"),
    "studies.compare.compare": ("Comparison", "compare"),
    "studies.fit.fit": ("fit",),
    "studies.fit.result": ("Fit", "LawFit"),
    "studies.compare.runs": ("LawRun",),
    "studies.sweep.sweep": ("sweep",),
    "studies.sweep.table": ("Sweep",),
    "study_data.ranking.effects": ("Effect",),
}
"""Module → the public names that are defined in this module; type checkers read the same in __init__.pyi."""
_HOMES = {name: f"chain_impact.{module}" for module, names in _MODULES.items() for name in names}

__all__ = sorted(_HOMES)  # noqa: PLE0605 - the names of the table


def __getattr__(name: str) -> Any:
    """Import a public name when it is used for the first time."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = exported = getattr(import_module(_HOMES[name]), name)
    return exported


def __dir__() -> list[str]:
    """Return the public names only, for completion; modules of the package can be imported all the same."""
    return list(__all__)
