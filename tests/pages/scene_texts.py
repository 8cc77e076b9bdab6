"""Scene files with rare keys."""

WRITTEN_SCENE = """
name = "Written"
chain = { base = "pinned", links = [
  { count = 2, length = 0.5, mass = 1, joint_friction = 0.1, joint_torque_limit = 3.0 },
  { length = 0.4, mass = 0.5, inertia = 0.01, joint_min = "-90 deg", joint_max = 1.5, joint_armature = 0.002 }
] }
walls = [
  { name = "ramp", point = [0, -2], normal = [0.3, 1] },
  { name = "side", point = [2, 0], angle = "90 deg" },
]
[box]
y_max = 5
[contact]
points = [2, 3]
friction = 0.2
wall = { ramp = { stiffness = 1e7, restitution = 0.4 }, y_max = { static_friction = 0.9 } }
[stops]
model = "flores"
restitution = 0.6
[inputs]
joint_torques = true
joint_targets = true
tip_force = true
base_motion = true
wall_motion = true
[signals.swing]
input = "joint[1].target_angle"
form = "sine"
amplitude = "33.3 deg"
frequency = 2
phase = "90 deg"
[signals.turn]
input = "joint[3].target_velocity"
form = "steps"
times = [0, 0.1]
values = [0.5, "66.6 deg/s"]
[initial]
joint_angles = ["-77.7 deg", 0.1, 0.2]
[outputs]
loads = true
impacts = 3
links = false
"""
BODIES = {
    "box": """
name = "Brick"
[[chain.links]]
length = 0.5
mass = 1.0
shape = "box"
height = 0.2
center_of_mass_offset = 0.01
points = [{ x = 0.6, radius = 0.03, name = "tip" }, { x = 0.0 }]
[box]
y_min = 0.0
[contact]
points = []
radius = 0.01
friction = 0.3
[initial]
position = [0.0, 0.5]
angles = ["30 deg"]
[outputs]
loads = true
impacts = 2
""",
    "foot": """
name = "Foot"
walls = [{ name = "ramp", point = [0, -2], angle = 0.1 }]
[chain]
base = "pinned"
links = [
  { length = 0.4, mass = 1.0, joint_min = -3.0, points = [{ x = 0.0 }, { x = 0.2, y = 0.1 }] },
  { length = 0.1, mass = 0.2, points = [{ x = -0.05, y = -0.05, name = "heel" }] },
]
[contact]
wall = { ramp = { friction = 0.2 } }
[initial]
joint_angles = [-1.0, 0.5]
""",
    "cart": """
name = "Cart"
[chain]
base = "slider"
links = [{ length = 0.5, mass = 0.5, joint_max = 3.0, points = [{ x = 0.0, radius = 0.1 }] }]
[chain.slider]
angle = "90 deg"
mass = 2.0
friction = 3.0
stiffness = 10.0
rest_position = 0.1
min = -0.5
max = 1.0
force_limit = 50.0
[box]
x_min = -3.0
y_min = -2.0
[initial]
angles = [-1.0]
slider_velocity = 0.4
[inputs]
slider_force = true
wall_motion = ["y_min"]
[outputs]
loads = true
""",
    "zeros": """
name = "Zeros"
[chain]
base = "slider"
slider = { friction = 0 }
[[chain.links]]
length = 0.5
mass = 0.5
[[chain.links]]
length = 0.5
mass = 0.5
center_of_mass_offset = 0
joint_armature = 0
joint_friction = 0
[box]
y_min = -2.0
[contact]
friction = 0
[initial]
angles = [-1.0, 0.5]
""",
    "rail": """
name = "Rail"
chain = { base = "slider", links = [{ length = 0.5, mass = 0.5 }] }
contact = { points = [0, 1] }
initial = { angles = [-1.0], slider_velocity = 1.0 }
walls = [
  { name = "across", point = [-1, 0], angle = "-90 deg" },
  { name = "floor", point = [0, -2], angle = 0 },
  { name = "cellar", point = [0, -3], angle = 0 },
]
""",
    "driven cart": """
name = "Driven"
chain = { base = "slider", links = [{ length = 0.5, mass = 0.5 }] }
contact = { points = [] }
inputs = { joint_targets = true }
initial = { angles = [-1.0] }
""",
}
