"""chain-impact: the impact dynamics of planar robotic chains, as an FMU."""

from chain_impact.export.aot import BuildError
from chain_impact.export.fmu import build_fmu
from chain_impact.kernel.contact_laws import CONTACT_LAWS
from chain_impact.scene import Scene, SceneError, load_scene
from chain_impact.simulate import Result, SimulationError, simulate, with_law

__all__ = [
    "CONTACT_LAWS",
    "BuildError",
    "Result",
    "Scene",
    "SceneError",
    "SimulationError",
    "build_fmu",
    "load_scene",
    "simulate",
    "with_law",
]
