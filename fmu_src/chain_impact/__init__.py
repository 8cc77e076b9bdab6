"""chain-impact: the impact dynamics of planar robotic chains, as an FMU."""

from chain_impact.compilation.errors import BuildError
from chain_impact.extras import MissingExtraError
from chain_impact.fmu.build import build_fmu, validate_fmu
from chain_impact.fmu.run import record_fmu
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.laws.registry import ContactLaw
from chain_impact.results.animation import AnimationError
from chain_impact.results.impacts import IMPACT_DTYPE, impacts_of
from chain_impact.results.recording import Recording
from chain_impact.results.result import Result
from chain_impact.results.sensitivity import Sensitivities
from chain_impact.results.stick_slip import STICK_SLIP_DTYPE
from chain_impact.scene.models import model_names
from chain_impact.scene.reading import SceneError, SceneWarning, UnknownNameError
from chain_impact.scene.scene import Scene, load_scene, parse_scene, with_values
from chain_impact.scene.stiffness import sphere_plane_stiffness
from chain_impact.simulation.chain import Chain
from chain_impact.simulation.derivatives import Differentiated, DifferentiatedRun
from chain_impact.simulation.inputs import Signal
from chain_impact.simulation.instance import SimulationError
from chain_impact.simulation.record_scene import RunError
from chain_impact.simulation.simulate import simulate, with_law
from chain_impact.studies.animate import animate
from chain_impact.studies.compare import Comparison, LawRun, compare
from chain_impact.studies.explore import explore
from chain_impact.studies.fit.fit import fit
from chain_impact.studies.fit.result import Fit, LawFit
from chain_impact.studies.slow_motion import record_slowly
from chain_impact.studies.sweep.sweep import sweep
from chain_impact.studies.sweep.table import Sweep

__all__ = [
    "CONTACT_LAWS",
    "IMPACT_DTYPE",
    "STICK_SLIP_DTYPE",
    "AnimationError",
    "BuildError",
    "Chain",
    "Comparison",
    "ContactLaw",
    "Differentiated",
    "DifferentiatedRun",
    "Fit",
    "LawFit",
    "LawRun",
    "MissingExtraError",
    "Recording",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Sensitivities",
    "Signal",
    "SimulationError",
    "Sweep",
    "UnknownNameError",
    "animate",
    "build_fmu",
    "compare",
    "explore",
    "fit",
    "impacts_of",
    "load_scene",
    "model_names",
    "parse_scene",
    "record_fmu",
    "record_slowly",
    "simulate",
    "sphere_plane_stiffness",
    "sweep",
    "validate_fmu",
    "with_law",
    "with_values",
]


def __dir__() -> list[str]:
    """The public names only, for those who look for one; the modules can be imported all the same."""
    return sorted(__all__)
