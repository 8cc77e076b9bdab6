"""The slider: a base on a carriage that slides along a straight line, in the direction u.

Its coordinate is s = u·(p₀ − o), from the initial position o of the base. For an acceleration a of the base
the chain needs the force A a + b at the base (chain/elimination.py). Along the line the equation of motion is

    a = s̈ u,   (u·A u + m) s̈ = F + u·(m g − b),

with m the mass of the carriage, g gravity, and F the force of motor, spring and damper. Across the line the
guide carries every force. The spring and the damper are a servo if there are targets, and the force of motor,
spring and damper together may have a limit, as in the joints (drives.py). Dry friction is an element
(forces/friction.py), and ends of the line are stops (rows/geometry.py), which the base touches.
"""

from chain_impact.kernel.chain.drives import limited_drive, wanted_drive
from chain_impact.kernel.chain.state import velocity_at


def slide_along(d, vector_x, vector_y):
    """Return the component of a vector along the line."""
    return d.slider.ux * vector_x + d.slider.uy * vector_y


def slider_position(d, y):
    """Return the coordinate s [m] of the slider in the state y."""
    return slide_along(d, y[0] - d.initial.position[0], y[1] - d.initial.position[1])


def rate_along_line(d, y):
    """Return the rate of the slider's coordinate: ṡ [m/s] if y is a state, s̈ [m/s²] if y is a rate."""
    n = d.links
    return slide_along(d, y[velocity_at(n)], y[velocity_at(n) + 1])


def is_slider_drive(d):
    """Return whether the slider has a drive, which is a servo or has a limit of its force.

    The work of its spring, damper and motor then counts as supplied energy.
    """
    return d.model.has_servos != 0 or d.slider.force_limit < float("inf")


def slider_damping(d):
    """Return the damping c [N·s/m] of the slider; 0 without a slider and while the force is at its limit."""
    return d.slider.damping if d.slides and d.slider.mode == 0 else 0.0


def slider_stiffness(d):
    """Return the stiffness k [N/m] of the slider; 0 without a slider and while the force is at its limit."""
    return d.slider.stiffness if d.slides and d.slider.mode == 0 else 0.0


def slider_resistance(d, time):
    """Return the resistance κ = t c + t² k [kg] of the damper and the spring; ``time`` is t [s]."""
    return time * (slider_damping(d) + time * slider_stiffness(d))


def slider_stretch(d, y):
    """Return s − s₀ [m], the distance from the spring's rest or target position s₀."""
    return slider_position(d, y) - d.inputs.slider_target_position[0]


def wanted_force(d, y):
    """Return the force [N] of motor, damper and spring before it is limited.

    The force is u − c (ṡ − v_t) − k (s − s₀), with the target v_t of the velocity and the target or rest
    position s₀.
    """
    inputs = d.inputs
    rate = rate_along_line(d, y) - inputs.slider_target_velocity[0]
    return wanted_drive(
        inputs.slider_force[0], d.slider.damping, rate, d.slider.stiffness, slider_stretch(d, y)
    )


def slider_force(d, y):
    """Return the force F [N] of motor, spring and damper; in a mode of ±1 it is ± the limit."""
    return limited_drive(wanted_force(d, y), d.slider.force_limit, d.slider.mode)


def slider_power(d, y):
    """Return two powers [W]: the one that the damper dissipates, and the one that the motor supplies.

    A drive supplies the whole power of motor, spring and damper, and dissipates none.
    """
    rate = rate_along_line(d, y)
    if is_slider_drive(d):
        return 0.0, slider_force(d, y) * rate
    return d.slider.damping * rate * rate, d.inputs.slider_force[0] * rate


def slider_spring_energy(d, y):
    """Return the energy [J] of the slider's spring; 0 if the slider has a drive."""
    stretch = slider_stretch(d, y)
    return 0.0 if is_slider_drive(d) else 0.5 * d.slider.stiffness * stretch * stretch


def carriage_energy(d, y):
    """Return kinetic and potential energy [J] of the carriage."""
    rate, gravity = rate_along_line(d, y), d.model.gravity
    return 0.5 * d.slider.mass * rate * rate, -d.slider.mass * (gravity[0] * y[0] + gravity[1] * y[1])
