"""Steps near a stop of a joint that end without a search for events."""

import pytest

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.events.exclusion import excludes_events
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import scene_from_dict
from chain_impact.variables.model import Model
from tests.plain import Plain


@pytest.mark.parametrize("lengths", [(2.0, 0.01), (0.01, 2.0, 0.02), (1.0, 1.0, 0.5), (2.0,)])
def test_near_a_stop_it_counts_that_both_links_of_the_joint_may_have_an_error(lengths):
    """Each angle may have an error as large as the tolerance: with a link far longer than the others, too."""
    tolerance, last = 1e-3, len(lengths)
    links = [{"length": length, "mass": 1.0} for length in lengths]
    links[-1]["joint_max"] = 0.5
    allowed = tolerance * (2.0 * max(lengths) if last > 1 else max(lengths))
    for share, excluded in ((0.9, False), (1.1, sum(lengths) <= 1.1 * allowed / tolerance)):
        angles = [0.0] * (last - 1) + [0.5 - share * allowed / max(lengths)]
        scene = scene_from_dict(
            {
                "name": "Still",
                "gravity": [0.0, 0.0],
                "chain": {"base": "pinned", "links": links},
                "solver": {"tolerance": tolerance},
                "initial": {"angles": angles},
            },
            "still",
        )
        d = Plain(Model(scene).new_instance()[0])
        assert initialize(d, 0.0) == OK
        d.step.end, d.work.rate_start[:] = 0.01, 0.0
        locate_points(d, d.step.state_end)
        accelerate_points(d, d.step.state_end, d.work.rate_start)
        assert excludes_events(d) == excluded
