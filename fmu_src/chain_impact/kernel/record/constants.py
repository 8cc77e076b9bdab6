"""The numbers that layouts of the record need: lengths of arrays, and codes that fields contain."""

# ---- methods of integration and their steps
EXPLICIT, IMPLICIT = 0, 1  # values of step.method and step.last_method: the two methods of integration
SOLVER_METHODS = ("auto", "explicit", "implicit")
"""The values of the scene key `solver.method`, numbered from 1; with `auto` the solver chooses the method."""
# The outcomes of a tried step, values of trial.outcome:
# INACCURATE     the error exceeds the tolerance, or the step loses more energy than is allowed
# INFINITE       the error, or a correction by Newton's iteration, is infinite or NaN
# CHECK_FAILED   an event cannot be located, forces are not found, or the energy is wrong
# TIME_REVERSED  a regularized step goes too far beyond the contact's end, or its time does not increase
# NEWTON_SLOW    Newton's iteration would need too many iterations
# DIVERGED       a correction by Newton's iteration exceeds the correction before, or is far too large
ACCEPTED, INACCURATE, INFINITE, CHECK_FAILED, TIME_REVERSED, NEWTON_SLOW, DIVERGED = 0, 1, 2, 3, 4, 5, 6
DENSE_COEFFICIENTS = 7  # number of coefficients of the dense output (ode/dense_output.py)
STAGE_COUNT = 16  # number of stages of an explicit step, with those of the dense output (ode/explicit.py)
RADAU_STAGES = 5  # number of stages of an implicit step (ode/radau.py)
PAIR_COUNT = 2  # number of pairs of complex eigenvalues of the matrix Q (ode/radau.py)
SLOT_COUNT = 3  # number of slots of `scratch.factors` (chain/mass_matrix_solver.py)
# values of step.dense_for: for whom the step's dense output was completed; NO_READER: for nobody yet
NO_READER, OUTPUT_READER, SOLVER_READER = 0, 1, 2
# value of step.regularized_candidate if no contact is regularized: the integration variable of the step is
# time
NO_CONTACT = -1

# ---- events, contacts and dry friction
NO_EVENT, ONSET, CONTACT_ENDS, RELATCH, RELEASE, KINK = 0, 1, 2, 3, 4, 5  # values of ``contacts.event``
# a value of ``contacts.event`` that the search never sets: a point near a rigid wall takes part in the impact
# of another point
NEIGHBOUR = 6
# values of ``friction_element.event``: the two kinds of changes of a friction mode
SLIDING_ENDS, STICKING_ENDS = 1, 2
# values of `search.known_extent`, which tell what is known of φ (`search.phi_end`) at the end of the last
# step. NOTHING_KNOWN: no φ; VALUES_KNOWN: φ and φ′ of the candidates; CURVATURES_KNOWN: also φ″;
# DISTANCE_KNOWN: only that every candidate without contact has at least the clearance `search.safe_distance`
NOTHING_KNOWN, VALUES_KNOWN, CURVATURES_KNOWN, DISTANCE_KNOWN = 0, 1, 2, 3
STICKS, NO_FRICTION = 0, 2  # values of `friction_element.mode`; the values ±1 stand for sliding along ±t
WALLS = ("x_min", "x_max", "y_min", "y_max")
"""The walls of the box in the order of their numbers, from 0. The numbers of walls at any angle follow."""
# [1] a slider's line and a wall count as parallel if the cosine of the angle between the line and the wall's
# normal differs from 0 by less than PARALLEL_COSINE, which allows for round-off
PARALLEL_COSINE = 1e-12

# ---- given values
NOT_GIVEN = -1.7976931348623157e308
"""The number in the field of a given value if no value is given, so that the kernel derives the value.

NOT_GIVEN is the lowest double; no scene gives this number as a value.
"""

# ---- inputs and signals
INPUT_DEGREE = 9  # the highest degree of the polynomials of a piece of the inputs
CONSTANT, SINE, RAMP, STEPS, TABLE = 0, 1, 2, 3, 4  # values of signal.form, the kind of a signal
SMOOTH, LINEAR, TRAPEZOID = 0, 1, 2  # values of signal.shape, the shape of a ramp
# the largest degree of a signal's polynomials: a ramp has degree 5, and is integrated twice if it is an
# acceleration
SIGNAL_DEGREE = 7
