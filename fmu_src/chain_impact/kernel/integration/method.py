"""The methods of integration, as data. Which function does what for them is in methods.py.

Explicit steps are stable for equations that are not stiff; they evaluate the rate at their end, as the first
stage of the next step. Implicit steps are stable however stiff the equations are. The end of an implicit step
is more accurate than its dense output, so that it is repeated to end at an event, and its method finds a size
for the first step after one.
"""

EXPLICIT, IMPLICIT = 0, 1  # step.method: the current method
SOLVER_METHODS = ("auto", "explicit", "implicit")
"""The choices of `solver.method`, counted from 1: the first leaves it to the solver."""
AUTO = 1

# By the number of the method: the error of a step over its length is proportional to h to the ORDER; SAFETY
# is a factor on the size of the next step that the last error suggests; the first step of a contact is of
# ONSET_SIZE times its time scale, at a tolerance of 1, with an error proportional to its size to the
# ONSET_ORDER.
ORDER = (8, 7)
SAFETY = (0.8, 0.85)
ONSET_SIZE = (4.5, 1.2)
ONSET_ORDER = (8, 3.5)  # the force, δ^(3/2), integrated twice


def chosen(choice):
    """The number of the method that `solver.method` prescribes, or −1 for `auto`."""
    return choice - AUTO - 1


def first_method(choice):
    """The number of the method that a run begins with."""
    return EXPLICIT if choice == AUTO else chosen(choice)
