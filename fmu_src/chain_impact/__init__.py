"""chain-impact: the impact dynamics of planar robotic chains, as an FMU."""

from chain_impact.compilation.errors import BuildError
from chain_impact.export.fmu import build_fmu
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.reading import SceneError
from chain_impact.results.recording import Recording
from chain_impact.results.result import Result
from chain_impact.running import SimulationError
from chain_impact.runs import RunError, record_fmu
from chain_impact.scene import Scene, load_scene
from chain_impact.simulate import simulate, with_law
from chain_impact.stiffness import sphere_plane_stiffness
from chain_impact.studies.compare import Comparison, compare

__all__ = [
    "CONTACT_LAWS",
    "BuildError",
    "Comparison",
    "Recording",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "SimulationError",
    "build_fmu",
    "compare",
    "load_scene",
    "record_fmu",
    "simulate",
    "sphere_plane_stiffness",
    "with_law",
]
