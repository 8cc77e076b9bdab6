"""Templates of small robot files, into which tests put features that a plain chain of links does not have."""

import pytest

from chain_impact import SceneError
from chain_impact.conversion.convert import scene_of_robot
from chain_impact.conversion.planar import ConversionChoices

ARM = """
<mujoco model="{name}">
  <option {option}>{flags}</option>
  {asset}
  <worldbody>
    {world}
    <body name="upper" pos="0 0 1.5" {upper}>
      <joint name="a" axis="0 1 0" {a}/>
      <geom name="upper" type="capsule" fromto="0 0 0 .4 0 0" size=".03" mass="2" {shape}/>
      {more}
      <body name="lower" pos=".4 0 0" {lower}>
        <joint name="b" axis="0 1 0" {b}/>
        <geom name="lower" type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" {shape}/>
        <site name="tip" pos=".3 0 0"/>
      </body>
    </body>
  </worldbody>
  {rest}
</mujoco>
"""
FREE_ROBOT = """
<mujoco model="free">
  <option {option}/>
  <worldbody>
    <body name="trunk" pos="0 0 2">
      <joint name="x" type="slide" axis="1 0 0" {x}/>
      <joint name="z" type="slide" axis="0 0 1" {z}/>
      <joint name="turn" axis="0 1 0" {turn}/>
      <geom type="capsule" fromto="0 0 0 0 0 -.5" size=".05" mass="1"/>
      <body name="leg" pos="0 0 -.5">
        <joint name="knee" axis="0 1 0" stiffness="3" springref="40"/>
        <geom type="capsule" fromto="0 0 0 0 0 -.4" size=".04" mass=".7"/>
        <site name="foot" pos="0 0 -.4"/>
      </body>
    </body>
  </worldbody>
  {rest}
</mujoco>
"""
CART = """
<mujoco model="cart">
  <worldbody>
    <body name="box" pos=".1 0 1.5" euler="0 15 0" {box}>
      <joint name="x" type="slide" axis="1 0 0" {x}/>
      <geom type="box" size=".1 .1 .05" mass="3"/>
      <body {box}><geom type="sphere" size=".05" pos="0 0 .1" mass=".5"/></body>
      <body name="upper" pos=".05 0 0" {upper}>
        <joint name="a" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 .4 0 .1" size=".03" mass="2"/>
        <body name="lower" pos=".4 0 0" {lower}>
          <joint name="b" axis="0 -1 0" stiffness="3"/>
          <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1"/>
        </body>
      </body>
    </body>
  </worldbody>
  {rest}
</mujoco>
"""
PARTS = (
    "option",
    "flags",
    "asset",
    "world",
    "upper",
    "lower",
    "a",
    "b",
    "shape",
    "more",
    "rest",
    "box",
    "x",
    "z",
    "turn",
)


def arm(**parts):
    """Return the MJCF of an arm of two links in the x–z plane."""
    return ARM.format(**{**dict.fromkeys(PARTS, ""), "name": "arm", **parts})


def free(**parts):
    """Return the MJCF of two links with a free base."""
    return FREE_ROBOT.format(**{**dict.fromkeys(PARTS, ""), **parts})


def cart(**parts):
    """Return the MJCF of an arm on a cart, which slides along an inclined line."""
    text = CART.replace('axis="1 0 0" ', "") if "axis=" in parts.get("x", "") else CART
    return text.format(**{**dict.fromkeys(PARTS, ""), **parts})


def drives(*actuators):
    """Return the element of MJCF with some actuators."""
    return f"<actuator>{''.join(actuators)}</actuator>"


def key(**values):
    """Return the element of MJCF with one keyframe, k."""
    attributes = " ".join(f'{name}="{value}"' for name, value in values.items())
    return f"<keyframe><key name='k' {attributes}/></keyframe>"


LINK = """
  <link name="{name}"><inertial><origin xyz="{center}"/><mass value="{mass}"/>
    <inertia ixx=".01" iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial>{content}</link>
"""
JOINT = """
  <joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{place}"/><axis xyz="{axis}"/>{content}</joint>
"""


def link(name, center=".15 0 0", mass=1, content=""):
    """Return a link of URDF, with ``content`` as further elements."""
    return LINK.format(name=name, center=center, mass=mass, content=content)


def joint(name, parent, child, place="0 0 0", **attributes):
    """Return a joint of URDF, by default a hinge about y without limits."""
    values = {"axis": "0 1 0", "kind": "continuous", "content": "", **attributes}
    return JOINT.format(name=name, parent=parent, child=child, place=place, **values)


def urdf(*parts, attributes=""):
    """Return the URDF of links and joints, with a link ``base`` in front of these."""
    return f'<robot name="r" {attributes}><link name="base"/>{"".join(parts)}</robot>'


TWO = (
    link("upper"),
    link("lower", mass=0.5),
    '<link name="tool"/>',
    joint("a", "base", "upper", "0 0 1"),
    joint("b", "upper", "lower", ".3 0 0"),
    joint("end", "lower", "tool", ".3 0 0", kind="fixed"),
)
"""An arm of two links."""


def read(tmp_path, text, **choices):
    """Return the scene of a robot file with a text, and the result of its conversion."""
    file = tmp_path / ("robot.xml" if "<mujoco" in text else "robot.urdf")
    file.write_text(text, encoding="utf-8")
    return scene_of_robot(file, ConversionChoices(**choices))


def refused(tmp_path, text, **choices):
    """Return the error of a robot file with a text, one line."""
    with pytest.raises(SceneError) as caught:
        read(tmp_path, text, **choices)
    assert "\n" not in str(caught.value)
    return str(caught.value)
