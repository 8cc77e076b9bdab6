"""Grazes: a point that penetrates a wall slightly, or almost reaches the wall, in closed-form motions.

The maximal height is known, and a run without the wall shows the error there. A penetration above that error
must give an impact, and a distance above that error must give none. Force laws ignore penetrations below
HARMLESS_DEPTH of a link length, a picometre.
"""

import numpy as np
import pytest

from chain_impact.kernel.forces.candidate_laws import HARMLESS_DEPTH
from tests.scenarios.grazes import FAR, instance, run, set_motion

pytestmark = pytest.mark.full("takes long")

CASES = 500  # number of cases of each motion
ROUND_OFF = 2e-14  # m, of positions of some metres
# minimal share of cases that can be judged, because the error of the run is small enough
JUDGED = {"thrown": 0.95, "spinning": 0.6}
LAWS = ("hertz", "newton_impact", "kuwabara_kono")


@pytest.mark.parametrize("motion", ["thrown", "spinning"])
def test_every_graze_is_found_and_no_other(motion):
    random, clear = np.random.default_rng(len(motion)), 0
    rods = {law: instance(law) for law in LAWS}
    for case in range(CASES):
        law = LAWS[case % len(LAWS)]
        rod = rods[law]
        top, height = set_motion(rod.record, random, motion)
        error = abs(run(rod, FAR, top)[0] - height) + ROUND_OFF
        depth = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-12.0, -3.0)
        _, hits = run(rod, height - depth, 1.2 * top)
        if depth > 0.0 and law != "newton_impact":
            error += HARMLESS_DEPTH * float(rod.record["chain"]["length"][0])
        if abs(depth) > error:
            clear += 1
            assert (hits > 0) == (depth > 0.0), (case, law, depth, error)
    assert clear >= JUDGED[motion] * CASES
