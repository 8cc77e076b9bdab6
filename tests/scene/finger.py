"""A scene file with stops, a wall of another material, and a pinned chain."""

FINGER = """
name = "Finger"
chain.base = "pinned"
initial.angles = [0.0, "45 deg"]
[[chain.links]]
length = 0.1
mass = 0.2
joint_min = "-90 deg"
[[chain.links]]
length = 0.1
mass = 0.2
joint_min = 0.0
joint_max = 2.0
[box]
x_max = 1.0
y_max = 0.5
[contact]
exponent = 2
[contact.wall.y_max]
restitution = 0.25
[stops]
stiffness = 500
"""
