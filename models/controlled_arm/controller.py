"""The controller of the arm: a digital PD controller with limited torques, as a slave for pythonfmu.

The inputs have the names of the arm's outputs, and the outputs have the names of the arm's inputs.
"""

from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real

# values of each joint, the shoulder first: target angle [rad], proportional gain [N·m/rad], derivative gain
# [N·m·s/rad], and the largest torque [N·m]
PARAMETERS = {
    "target": (-1.0, 0.6),
    "proportional": (100.0, 40.0),
    "derivative": (10.0, 3.0),
    "limit": (30.0, 12.0),
}
JOINTS = 2


class JointController(Fmi2Slave):
    """A PD controller for each joint: values sampled at the start of a step give torques from its end."""

    def __init__(self, **kwargs):
        """Register the variables."""
        super().__init__(**kwargs)
        self.description = "PD controller with limited torques for the arm's two joints"
        self.angle, self.angular_velocity, self.torque = ([0.0] * JOINTS for _ in range(3))
        for name, values in PARAMETERS.items():
            setattr(self, name, list(values))
        for i in range(JOINTS):
            for name in PARAMETERS:
                self._register(f"joint[{i + 1}].{name}", name, i, Fmi2Causality.parameter)
            for name in ("angle", "angular_velocity"):
                self._register(f"link[{i + 1}].{name}", name, i, Fmi2Causality.input)
            self._register(f"joint[{i + 1}].torque", "torque", i, Fmi2Causality.output)

    def _register(self, name, values, i, causality):
        values = getattr(self, values)
        fixed = causality == Fmi2Causality.parameter
        variable = Real(
            name,
            causality=causality,
            variability=Fmi2Variability.fixed if fixed else Fmi2Variability.continuous,
            initial=None if causality == Fmi2Causality.input else Fmi2Initial.exact,
            getter=lambda: values[i],
            setter=lambda value: values.__setitem__(i, value),
        )
        self.register_variable(variable)

    def do_step(self, current_time, step_size):  # noqa: ARG002
        """Compute the torques from the inputs."""
        for i in range(JOINTS):
            # q_i = θ_i − θ_{i−1}
            q = self.angle[i] - (self.angle[i - 1] if i else 0.0)
            rate = self.angular_velocity[i] - (self.angular_velocity[i - 1] if i else 0.0)
            # u_i = kp_i (q*_i − q_i) − kd_i q̇_i, between −u_max and u_max
            torque = self.proportional[i] * (self.target[i] - q) - self.derivative[i] * rate
            self.torque[i] = min(max(torque, -self.limit[i]), self.limit[i])
        return True
