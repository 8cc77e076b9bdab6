"""Random chains of bodies; ``python -m tests.helpers.campaigns.random_bodies`` searches more scenes."""

import pytest

from chain_impact import simulate
from tests.helpers.campaigns.random_bodies import DRIVEN, bodies, faults, wrong_energy, wrong_motion

# Scenes with former faults: a row with the acceleration of an unreported force, a row that depended on
# earlier rows, two sticking corners of a box, a limit passed between two stages, and a corner that slides
# along a rigid wall.
MENDED = (10254, 10410, 14065, 14072, 15739)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("seeds", [(*range(8), *range(DRIVEN, DRIVEN + 6), *MENDED), range(12, 60)], ids=str)
def test_random_bodies_keep_the_laws_of_physics(seeds):
    faults_of_seed = {seed: seed_faults for seed in seeds if (seed_faults := faults(seed))}
    assert not faults_of_seed


def test_a_peak_after_a_change_of_friction_is_found():
    """A decreasing force rises again as a joint and a contact begin to slide: its second peak is higher."""
    run = simulate(bodies(6).with_values({"solver.method": "explicit"}), 0.1, output_step=1e-5)
    first = run.impacts[0]
    rows = run.time <= first["end"]
    assert first["peak_force"] == pytest.approx(run["contact[9].w0.force"][rows].max(), rel=1e-5)


def test_a_wrong_acceleration_and_a_lost_energy_are_found():
    run = simulate(bodies(3), output_step=0.01)
    assert not wrong_motion(run) + wrong_energy(run)
    run.outputs["angular_acceleration"] *= 1.0 + 1e-7
    run.outputs["dissipated"][-1] += 1e-3 * run.energy["kinetic"].max()
    assert {text.partition(":")[0] for text in wrong_motion(run) + wrong_energy(run)} == {"newton", "energy"}
