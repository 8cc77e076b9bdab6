"""The carriage: a mass on a rail with a spring and a damper, as a slave for pythonfmu.

The input has the name of the arm's output, and the outputs have the names of the arm's inputs. The input is
the *impulse* that the joint has transmitted, not the force: the change of the impulse over a step contains an
impact that begins and ends between two communication points.
"""

from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real

MASS, STIFFNESS, DAMPING = 20.0, 2000.0, 40.0  # kg, N/m, N·s/m
IMPULSE, OUTPUTS = "joint[1].impulse.x", ("base.x", "base.vx", "base.ax")


class Carriage(Fmi2Slave):
    """A carriage whose force in each step is the mean force of the previous step."""

    def __init__(self, **kwargs):
        """Register the variables."""
        super().__init__(**kwargs)
        self.description = "mass on a rail that carries the arm"
        self.values = dict.fromkeys((IMPULSE, *OUTPUTS), 0.0)
        self.known = 0.0  # N·s, the impulse at the start of the previous step
        for name in self.values:
            causality = Fmi2Causality.input if name == IMPULSE else Fmi2Causality.output
            variable = Real(
                name,
                causality=causality,
                variability=Fmi2Variability.continuous,
                initial=None if name == IMPULSE else Fmi2Initial.exact,
                getter=lambda name=name: self.values[name],
                setter=lambda value, name=name: self.values.__setitem__(name, value),
            )
            self.register_variable(variable)

    def do_step(self, current_time, step_size):  # noqa: ARG002
        """Advance by the equation of motion, m a = −F − k x − c v, with Heun's method.

        F is the mean force of the joint on the arm during the previous step.
        """
        impulse = self.values[IMPULSE]
        force, self.known = (impulse - self.known) / step_size, impulse
        x, v, _ = (self.values[name] for name in OUTPUTS)

        def acceleration(x, v):
            # the joint pushes the arm with F, and the carriage with −F
            return (-force - STIFFNESS * x - DAMPING * v) / MASS

        a = acceleration(x, v)
        b = acceleration(x + step_size * v, v + step_size * a)
        x += step_size * (v + 0.5 * step_size * a)
        v += 0.5 * step_size * (a + b)
        self.values.update(zip(OUTPUTS, (x, v, acceleration(x, v)), strict=True))
        return True
