"""The faults of scene files that Python and the page that simulates both refuse: their sentences and rules.

In an error, the path of the key comes before the sentence. Words in braces stand for texts of the scene. The
text after "; " is advice, in which Python may say more than the page. The conditions of the rules are in the
language of rule_language.py.
"""

from __future__ import annotations

from typing import NamedTuple

from chain_impact.kernel.status import WITHOUT_FRICTION

SENTENCES = {
    "no_table": "= {value} must be a table",
    "no_tables": "= {value} must be a table of tables",
    "unknown": "is unknown; the keys here are {keys}",
    "near_key": "is unknown; the nearest key is {near}",
    "missing": "is missing{meaning}",
    "not_allowed": "= {value} must be {allowed}",
    "no_list": "= {value} must be a list{names}{expected}",
    "one_table": "is one table, must be a list of tables: write [[{name}]]{others}",
    "length": "has {found}, must have {needed}",
    "entries": "has {count} entries, must have {least} to {most}",
    "links": "has {count} links, must have at most {most}",
    "no_height": "has shape but no height, must have both or neither",
    "no_shape": "has height but no shape, must have both or neither",
    "angles": "has both angles and joint_angles, must have one of them",
    "wall_angle": "has neither angle nor normal, must have one of them",
    "wall_angles": "has both angle and normal, must have one of them",
    "no_normal": "= {value} must not be zero",
    "no_wall": "{value}is not a wall of the scene; must be one of {walls}",
    "no_walls": "must be left out: the scene has no walls",
    "wall_name": "= {value} must be none of {others}",
    "out_of_reach": "= {value} must be left out with its wall: no point can reach it, because all "
    "points that may touch slide parallel to it",
    "box_width": "= {value} must be > {least} [m], which is {bound}",
    "joint_range": "= {value} must be > {least} [rad], which is joint_min",
    "static_friction": "= {value} must be >= {least}, the coefficient of sliding friction, or 0, which means "
    "equal to it",
    "law_restitution": "= {value} must be > 0 for the contact model {law}; newton_impact allows 0",
    "law_exponent": "= {value} must be {least} for the contact model {law}",
    "rigid_friction": "= {value} must be 0 for the contact model {law}: "
    f"{WITHOUT_FRICTION}; choose a law with a force",
    "points": "holds {value}, must hold only {first} to {last} with a {base} base, each at most once; "
    "points of chain.links[].points always touch",
    "point_names": "has two points with the name {value}",
    "no_stops": "= {value} must be left out: no link has a joint_min or joint_max",
    "no_joint": "= {value} must be left out: a free base has no joint 1"
    "; if link 1 comes from a `count`, write it as an entry of its own",
    "no_slider": 'must be left out: only a base on a slider has it: chain.base = "slider"',
    "no_slider_velocity": '= {value} must be 0: only a base on a slider has it: chain.base = "slider"',
    "no_slider_force": 'must be false: only a base on a slider has it: chain.base = "slider"',
    "slider_stops": "= {value} must be > {least} [m], which is min",
    "slider_min": "= {value} must be <= 0 [m]: the slider is at 0 at the start",
    "slider_max": "= {value} must be >= 0 [m]: the slider is at 0 at the start",
    "base_motion": 'must be false: inputs can move a base only with chain.base = "pinned"',
    "velocity_pinned": "= {value} must be zero for a pinned base",
    "velocity_slider": "= {value} must be left out for a base on a slider"
    "; initial.slider_velocity is its velocity along the line",
    "signal_name": "must have a name of letters, digits and _, not beginning with a digit",
    "other_form": 'must be left out: form = "{form}" has {keys}',
    "needs_key": 'is missing: form = "{form}" needs it',
    "no_input": "= [] must name at least one input",
    "strange_input": "= {value} is not an input of the scene; {how}",
    "driven_twice": "= {value} must be driven by one signal only: {by}",
    "units": "must name inputs of one unit: {first} is in {unit}, {other} in {other_unit}",
    "times": "has {times} entries, must have as many as values, which has {values}, and at least one",
    "late": "= {value} must be > {before} [s], the time before it",
    "no_frequency": "= 0 must be > 0, or frequency_rate must not be 0, because the driven input {input} is "
    'integrated; give form = "constant"',
    "steps_jump": '= "steps": {input} would jump, which would be an impact of unknown strength; take a ramp',
    "ramp_jumps": '= "linear": the velocity of {input} would jump, which would be an impact of unknown '
    'strength; take "smooth" or "trapezoid"',
    "sine_jumps": "= {value}: the velocity of {input} would jump, which would be an impact of unknown "
    "strength; give it a rise, a phase at which the sine is at rest, as pi/2, or start = 0",
}
"""Name of a fault → the sentence on this fault, with words in braces."""


class RefusalRule(NamedTuple):
    """A rule that refuses a value which contradicts other values.

    Attributes:
        fault: the name of the fault, a key of SENTENCES.
        key: the refused key; the value of this key replaces the word ``value`` in the sentence. "" stands for
            the table itself.
        condition: the condition, in the language of rule_language.py, that is true if the value is refused.
            Its names are keys and facts.
        least: an expression of this language for the number with which the sentence compares the value; ""
            for none. The number replaces the word ``least`` in the sentence, the text of the expression the
            word ``bound``.
        of: the tables for which the rule is checked, and to which the key belongs: "" is the whole file;
            "link" is each link; "wall" is each entry of ``walls``; "law" is [contact], each table in
            [contact.wall], and [stops]. With "law", a missing coefficient of friction of a wall, and a
            missing value of [stops], follow from [contact]. In such a rule, ``law`` is the contact law of the
            table; a user's law has no properties in rules.
        in_kernel: whether the kernel checks the rule, too, at the start of a run. A page does not check such
            a rule when its user changes one value, because the user may change the other value next.
    """

    fault: str
    key: str
    condition: str
    least: str = ""
    of: str = ""
    in_kernel: bool = False


GIVEN_REFUSALS = (
    RefusalRule("wall_angle", "", "not has_value(angle) and not has_value(normal)", of="wall"),
    RefusalRule("wall_angles", "", "has_value(angle) and has_value(normal)", of="wall"),
    RefusalRule("no_normal", "normal", "has_value(normal) and not normal", of="wall"),
    RefusalRule("no_height", "", "has_value(shape) and not has_value(height)", of="link"),
    RefusalRule("no_shape", "", "has_value(height) and not has_value(shape)", of="link"),
    RefusalRule("angles", "initial", "has_value(initial.angles) and has_value(initial.joint_angles)"),
)
"""Rules of a file before values that follow from others are added, in the order in which they are checked. A
value that the file does not give is missing."""
STOP_KEYS = ("model", "stiffness", "exponent", "restitution", "minimum_impact_speed")
REFUSALS = (
    RefusalRule(
        "law_restitution",
        "restitution",
        "restitution == 0 and law.allows_zero == 0",
        of="law",
        in_kernel=True,
    ),
    RefusalRule(
        "law_exponent", "exponent", "exponent != law.exponent", "law.exponent", of="law", in_kernel=True
    ),
    RefusalRule("velocity_pinned", "initial.velocity", "chain.base == 'pinned' and initial.velocity"),
    RefusalRule("velocity_slider", "initial.velocity", "chain.base == 'slider' and initial.velocity"),
    RefusalRule("no_slider", "chain.slider", "chain.base != 'slider' and chain.slider"),
    RefusalRule(
        "no_slider_velocity",
        "initial.slider_velocity",
        "chain.base != 'slider' and initial.slider_velocity",
    ),
    RefusalRule("no_slider_force", "inputs.slider_force", "chain.base != 'slider' and inputs.slider_force"),
    RefusalRule(
        "slider_stops", "chain.slider.max", "chain.slider.min >= chain.slider.max", "chain.slider.min"
    ),
    RefusalRule("slider_min", "chain.slider.min", "chain.slider.min > 0"),
    RefusalRule("slider_max", "chain.slider.max", "chain.slider.max < 0"),
    RefusalRule("base_motion", "inputs.base_motion", "chain.base != 'pinned' and inputs.base_motion"),
    RefusalRule(
        "box_width", "box.x_max", "box.x_max <= box.x_min + 2*contact.radius", "box.x_min + 2*contact.radius"
    ),
    RefusalRule(
        "box_width", "box.y_max", "box.y_max <= box.y_min + 2*contact.radius", "box.y_min + 2*contact.radius"
    ),
    RefusalRule("joint_range", "joint_max", "joint_max <= joint_min", "joint_min", "link"),
    RefusalRule(
        "static_friction",
        "static_friction",
        "static_friction > 0 and static_friction < friction",
        "friction",
        "law",
    ),
    *(
        RefusalRule("rigid_friction", key, f"law.rigid and {key} > 0", of="law", in_kernel=True)
        for key in ("friction", "static_friction")
    ),
    *(
        RefusalRule("no_joint", key, f"chain.base == 'free' and order == 0 and has_value({key})", of="link")
        for key in ("joint_min", "joint_max")
    ),
    *(
        RefusalRule(
            "no_stops",
            f"stops.{key}",
            f"has_value(stops.{key}) and not any(chain.links, has_value(joint_min) or has_value(joint_max))",
        )
        for key in STOP_KEYS
    ),
)
"""Rules of a file, in the order in which they are checked."""
ENTRY_REFUSALS = (
    RefusalRule("points", "", "not (entry in movable) or entry in before", of="contact.points"),
    RefusalRule(
        "out_of_reach", "", "reached and walls > reached and not (entry in reached)", of="walls.name"
    ),
    RefusalRule("wall_name", "", "entry in reserved or entry in before", of="walls.name"),
    RefusalRule("point_names", "", "entry and entry in before", of="chain.links.points.name"),
)
"""Rules for each entry of a list, in the order in which they are checked before ``REFUSALS``.

``of`` is the list; the key is "", because the path of the list or of the entry is that of the error. The
names in the rules are these facts. ``entry``: the value of the entry; ``before``: the entries before it in
the list; ``movable``: the points that can move; ``walls``: the number of entries of ``walls``; ``reached``: a
wall's name for each pair of a point and a wall that can touch (the kernel's record has room for as many
entries of ``walls`` as there are such pairs); ``reserved``: the names that no entry of ``walls`` may have.
"""
LAW_FACTS = ("id", "allows_zero", "exponent", "rigid")
"""The properties of a contact law that rules may name."""
SIGNAL_REFUSALS = (
    RefusalRule(
        "no_frequency", "frequency", "form == 'sine' and order > 0 and not frequency and not frequency_rate"
    ),
    RefusalRule("steps_jump", "form", "moves and form == 'steps' and order < 2 and steps_differ"),
    RefusalRule("ramp_jumps", "shape", "moves and form == 'ramp' and order == 0 and shape == 'linear'"),
    RefusalRule(
        "sine_jumps",
        "start",
        "moves and form == 'sine' and order == 0 and start > 0 and not rise and starts_fast",
    ),
)
"""Rules for a signal together with each input that the signal drives.

The names in the rules are keys of the signal and these facts. ``moves``: the input is a position, velocity or
acceleration of the base or a wall; ``order``: how often the input is integrated over time; ``steps_differ``:
not all values of the steps are equal; ``starts_fast``: the speed of a sine is not 0 at its start.
"""


def refusal_sentence(fault: str, **template_values: object) -> str:
    """Return the sentence on a fault, with the ``template_values`` in place of the words in braces."""
    return SENTENCES[fault].format_map(template_values)
