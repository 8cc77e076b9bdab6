"""chain-impact: the impact dynamics of planar robotic chains, in Python, on the command line and as FMUs.

A public name is imported from its module when it is used for the first time, since importing all modules
takes long.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from chain_impact.compilation.errors import BuildError as BuildError
    from chain_impact.extras import MissingExtraError as MissingExtraError
    from chain_impact.fmu.build import build_fmu as build_fmu, validate_fmu as validate_fmu
    from chain_impact.fmu.run import record_fmu as record_fmu
    from chain_impact.kernel.forces.contact_law import ContactLaw as ContactLaw
    from chain_impact.kernel.forces.laws import CONTACT_LAWS as CONTACT_LAWS
    from chain_impact.pages.explore import explore as explore
    from chain_impact.recording.impacts import IMPACT_DTYPE as IMPACT_DTYPE, impacts_of as impacts_of
    from chain_impact.recording.recording import Recording as Recording
    from chain_impact.recording.sensitivity import Sensitivities as Sensitivities
    from chain_impact.recording.stick_slip import STICK_SLIP_DTYPE as STICK_SLIP_DTYPE
    from chain_impact.results.animate import AnimationError as AnimationError
    from chain_impact.results.ranking import Effect as Effect, Ranking as Ranking
    from chain_impact.results.result import Result as Result
    from chain_impact.scene.errors import (
        SceneError as SceneError,
        SceneWarning as SceneWarning,
        UnknownNameError as UnknownNameError,
    )
    from chain_impact.scene.files.models import model_names as model_names
    from chain_impact.scene.scene import (
        Scene as Scene,
        load_scene as load_scene,
        parse_scene as parse_scene,
        with_values as with_values,
    )
    from chain_impact.scene.stiffness import sphere_plane_stiffness as sphere_plane_stiffness
    from chain_impact.simulation.chain import Chain as Chain
    from chain_impact.simulation.derivatives import (
        Differentiated as Differentiated,
        DifferentiatedRun as DifferentiatedRun,
    )
    from chain_impact.simulation.errors import RunError as RunError, SimulationError as SimulationError
    from chain_impact.simulation.inputs import Signal as Signal
    from chain_impact.simulation.simulate import simulate as simulate, with_law as with_law
    from chain_impact.studies.animate import animate as animate, record_slowly as record_slowly
    from chain_impact.studies.compare.compare import Comparison as Comparison, compare as compare
    from chain_impact.studies.compare.runs import LawRun as LawRun
    from chain_impact.studies.fit.fit import fit as fit
    from chain_impact.studies.fit.result import Fit as Fit, LawFit as LawFit
    from chain_impact.studies.sweep.sweep import sweep as sweep
    from chain_impact.studies.sweep.table import Sweep as Sweep

_MODULES = {
    "compilation.errors": ("BuildError",),
    "extras": ("MissingExtraError",),
    "fmu.build": ("build_fmu", "validate_fmu"),
    "fmu.run": ("record_fmu",),
    "kernel.forces.contact_law": ("ContactLaw",),
    "kernel.forces.laws": ("CONTACT_LAWS",),
    "results.animate": ("AnimationError",),
    "recording.impacts": ("IMPACT_DTYPE", "impacts_of"),
    "pages.explore": ("explore",),
    "results.ranking": ("Effect", "Ranking"),
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
    "simulation.inputs": ("Signal",),
    "simulation.simulate": ("simulate", "with_law"),
    "studies.animate": ("animate", "record_slowly"),
    "studies.compare.compare": ("Comparison", "compare"),
    "studies.fit.fit": ("fit",),
    "studies.fit.result": ("Fit", "LawFit"),
    "studies.compare.runs": ("LawRun",),
    "studies.sweep.sweep": ("sweep",),
    "studies.sweep.table": ("Sweep",),
}
"""Module → the public names that are defined in this module."""
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
