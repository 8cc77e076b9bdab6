"""The kink of a force, where it is cut off at 0 or damps no more: an event that a step of its own ends at."""

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.kernel.advance import advance
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events.marks import KINK
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.model.contact import kink_height
from chain_impact.kernel.model.contact_force import elastic_force
from chain_impact.kernel.status import OK
from chain_impact.variables.model import Model
from tests.kernel.model.test_contact_force import MASS, SPEED, STIFFNESS, scaled_impact
from tests.plain import Plain
from tests.problems import of_law, struck_ball

KINKED = ("kelvin_voigt", "tsuji", "kuwabara_kono", "jankowski")
TOLERANCES = 10.0 ** -np.arange(6, 14)
# Over the tolerance, of the largest error of a realised restitution; measured: 21
LARGEST_ERROR = 30.0


def struck(law, e):
    scene, _ = struck_ball(MASS, SPEED, **of_law(law), stiffness=STIFFNESS, restitution=e)
    return scene.with_values({"simulation.stop_time": 0.3})


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("law", KINKED)
@pytest.mark.parametrize("e", [0.1, 0.275, 0.5, 0.65, 0.8, 0.95])
def test_the_realised_restitution_errs_by_the_tolerance(law, e):
    """At every tolerance: no smaller one brings a larger error."""
    right, _, _ = scaled_impact(CONTACT_LAWS[law], e)
    for tolerance in TOLERANCES:
        (impact,) = simulate(struck(law, e), tolerance=tolerance, output=(), output_step=0.3).impacts
        error = abs(impact["separation_speed"] / impact["impact_speed"] - right)
        assert error <= LARGEST_ERROR * tolerance, tolerance


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("law", KINKED)
def test_a_step_ends_at_the_kink(law):
    d = Plain(Model(struck(law, 0.4).with_values({"solver.tolerance": 1e-9})).new_instance()[0])
    assert initialize(d, 0.0) == OK
    kinks = []
    while d.finished.count == 0:
        assert advance(d, np.nextafter(d.step.end, 1.0), 10, 1e9) == OK
        if d.touch.event[0] == KINK:
            locate_points(d, d.step.state_end)
            off = kink_height(d, 0) / (SPEED if d.law.approach_only[0] else elastic_force(d, 0, 1e-3))
            kinks.append((d.touch.beyond_kink[0], off))
    ((beyond, off),) = kinks
    assert beyond == 0
    assert abs(off) < 1e-9
