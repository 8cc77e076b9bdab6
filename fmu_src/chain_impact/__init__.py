"""chain-impact: the impact dynamics of planar robotic chains, as an FMU."""

from chain_impact.compare import Comparison, compare
from chain_impact.compilation.errors import BuildError
from chain_impact.export.fmu import build_fmu
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.reading import SceneError
from chain_impact.scene import Scene, load_scene
from chain_impact.simulate import Result, SimulationError, simulate, with_law
from chain_impact.stiffness import sphere_plane_stiffness

__all__ = [
    "CONTACT_LAWS",
    "BuildError",
    "Comparison",
    "Result",
    "Scene",
    "SceneError",
    "SimulationError",
    "build_fmu",
    "compare",
    "load_scene",
    "simulate",
    "sphere_plane_stiffness",
    "with_law",
]
