"""Random scene files."""

import math

from hypothesis import strategies as st

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import SOLVER_METHODS

finite_numbers = st.floats(-1e6, 1e6)
positive_numbers = st.floats(1e-6, 1e6)


@st.composite
def scene_dicts(draw):
    """Draw a valid scene file, without some of the optional keys."""
    counts = draw(st.lists(st.none() | st.integers(1, 3), min_size=1, max_size=4))
    count = sum(equal or 1 for equal in counts)
    pinned = draw(st.booleans())

    def table(**keys):
        return draw(st.fixed_dictionaries({}, optional=keys))

    def per_link(values):
        return st.lists(values, min_size=count, max_size=count)

    def link(equal):
        optional = table(
            center_of_mass=st.floats(0, 10), inertia=positive_numbers, joint_damping=st.floats(0, 10)
        )
        optional |= table(joint_stiffness=st.floats(0, 1e6), joint_rest_angle=st.floats(-10, 10))
        optional |= {"count": equal} if equal else {}
        return {"length": draw(st.floats(1e-3, 10)), "mass": draw(positive_numbers)} | optional

    distances = st.floats(1e3, 1e6)  # out of reach of the chain

    def wall(name):
        x, y = draw(st.sampled_from([(1e3, 0.0), (0.0, 1e4), (-1e4, 1e3), (-1e3, -1e5)]))
        toward = {"normal": [-x, -y]} if draw(st.booleans()) else {"angle": math.atan2(x, -y)}
        return {"name": name, "point": [x, y], **toward}

    start = st.lists(st.floats(-100, 100), min_size=2, max_size=2)
    return {
        "name": draw(st.from_regex(r"[A-Za-z_]\w*", fullmatch=True, alphabet=st.characters(codec="ascii"))),
        **table(description=st.text(st.characters(codec="utf-8", exclude_categories=["C"]))),
        **table(gravity=st.lists(finite_numbers, min_size=2, max_size=2)),
        "chain": {"base": "pinned" if pinned else "free", "links": [link(equal) for equal in counts]},
        "box": table(
            x_min=distances.map(lambda x: -x),
            x_max=distances,
            y_min=distances.map(lambda x: -x),
            y_max=distances,
        ),
        "walls": [wall(name) for name in draw(st.lists(st.sampled_from(["a", "b_", "C1"]), unique=True))],
        "contact": table(
            model=st.sampled_from([law.id for law in CONTACT_LAWS.values() if law.exponent is None]),
            stiffness=positive_numbers,
            exponent=st.floats(1, 3),
            restitution=st.floats(1e-3, 1),
            radius=st.floats(0, 100),
            points=st.lists(st.integers(int(pinned), count), unique=True),
            minimum_impact_speed=positive_numbers,
        ),
        "inputs": table(joint_torques=st.booleans(), tip_force=st.booleans()),
        "initial": {"angles": draw(per_link(finite_numbers))}
        | table(position=start, angular_velocities=per_link(finite_numbers))
        | ({} if pinned else table(velocity=st.lists(finite_numbers, min_size=2, max_size=2))),
        "solver": table(method=st.sampled_from(SOLVER_METHODS), tolerance=st.floats(1e-13, 1e-2)),
        "simulation": table(stop_time=positive_numbers, step_size=positive_numbers),
    }
