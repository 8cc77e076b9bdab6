"""The controller of the cart: it balances the pole, as a slave for pythonfmu.

The inputs have the names of the cart's outputs, and the output has the name of the cart's input.
"""

import math

from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real

# gains of the linear-quadratic regulator of the cart for the weights 20/m², 30/rad², 1 s²/m², 1 s²/rad² and
# 0.05/N²
GAINS = {
    "slider.position": 20.0,  # N/m
    "link[1].angle": -83.7,  # N/rad, from upright
    "slider.velocity": 18.2,  # N·s/m
    "link[1].angular_velocity": -16.3,  # N·s/rad
}
UPRIGHT = {"link[1].angle": 0.5 * math.pi}  # rad
FORCE = "slider.force"


class Balancer(Fmi2Slave):
    """State feedback: values sampled at the start of a step give the force from the end of the step."""

    def __init__(self, **kwargs):
        """Register the variables."""
        super().__init__(**kwargs)
        self.description = "state feedback that balances the pole on the cart"
        self.values = {name: UPRIGHT.get(name, 0.0) for name in GAINS} | {FORCE: 0.0}
        for name in self.values:
            causality = Fmi2Causality.output if name == FORCE else Fmi2Causality.input
            variable = Real(
                name,
                causality=causality,
                variability=Fmi2Variability.continuous,
                initial=Fmi2Initial.exact if name == FORCE else None,
                getter=lambda name=name: self.values[name],
                setter=lambda value, name=name: self.values.__setitem__(name, value),
            )
            self.register_variable(variable)

    def do_step(self, current_time, step_size):  # noqa: ARG002
        """Compute the force from the inputs."""
        # F = k·(x − x₀)
        away = {name: self.values[name] - UPRIGHT.get(name, 0.0) for name in GAINS}
        self.values[FORCE] = sum(gain * away[name] for name, gain in GAINS.items())
        return True
