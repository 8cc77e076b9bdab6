"""The slider: a base on a carriage that slides along a straight line, in the direction u.

The slider's coordinate is s = u·(p₀ − o), with the present position p₀ and the initial position o of the
base. For an acceleration a of the base the chain needs the force A a + b at the base (chain/elimination.py).
Along the line the equation of motion is

    a = s̈ u,   (u·A u + m) s̈ = F + u·(f + m g − b),

with m the mass of the carriage, g gravity, f the applied force on the base, and F the force of the slider's
drive (drives.py). The line carries any force across it. Dry friction of the slider is an element
(forces/friction.py). The slider's stops, if any, are candidates, which the base touches
(constraints/geometry.py).
"""

from chain_impact.kernel.record.state import velocity_at


def slider_component(d, vector_x, vector_y):
    """Return the component, along the slider's line, of the vector (``vector_x``, ``vector_y``)."""
    return d.slider.ux * vector_x + d.slider.uy * vector_y


def slider_position(d, y):
    """Return the coordinate s [m] of the slider in the state y: 0 at the initial position of the base."""
    return slider_component(d, y[0] - d.initial.position[0], y[1] - d.initial.position[1])


def carriage_energy(d, y):
    """Return the kinetic and the potential energy [J] of the carriage in the state y."""
    first, gravity = velocity_at(d.link_count), d.chain.gravity
    rate = slider_component(d, y[first], y[first + 1])
    return 0.5 * d.slider.mass * rate * rate, -d.slider.mass * (gravity[0] * y[0] + gravity[1] * y[1])
