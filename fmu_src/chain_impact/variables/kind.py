"""A kind of variables: variables that differ only in the number or the name of their owner, such as a link.

The names, texts and paths of a kind are templates. ``{n}`` stands for the number of an owner, ``{of}`` for
the number of the owner's link, ``{name}`` for the name of the owner's wall or signal, ``{axis}`` for x or y.
Any other word in braces in a text stands for words that depend on the scene or the owner
(description_texts.py). In a path, ``{at}`` stands for the index of the owner in the record, ``{next}`` for
this index plus 1, and any other word for the value with this name of the owner.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

from chain_impact.scene.rules.key_rules import Derived
from chain_impact.scene.texts.input_table import INPUT_KINDS
from chain_impact.scene.texts.names import AXES, OWNER_AT, DataPath, NameParts, name_parts, sensitivity_name

NEXT_OWNER_AT = "{next}"
GIVEN_CHANNEL = "given_channel"
"""The name of the part of the record with the motions given for base, walls and belts."""
CHANNEL_FIELDS = ("position", "velocity", "acceleration")
"""The fields of the part ``GIVEN_CHANNEL`` of the record that have the motions."""


class Heading(NamedTuple):
    """The first words of descriptions: ``text``, a template, for one variable; ``general`` for a kind."""

    text: str = ""
    general: str = ""


NO_HEADING = Heading()
SIGNAL = Heading("signal {name}", "signal")
LINK, JOINT = Heading("link {n}", "link i"), Heading("joint {n}", "joint i")
POINT = Heading("point {n}{label}", "point k")
CONTACT = Heading("{touching} at {name}", "point k at a wall")
SITE, SLIDER = Heading("point {n} of link {of}", "point j of link i"), Heading("slider", "slider")
SLOPED_WALL, WALL = Heading("wall {name}", "wall at any angle"), Heading("at wall {name}", "at one wall")
IMPACT = Heading("latest impact{but}", "impact i, 1 the latest")


@dataclass(frozen=True, kw_only=True)
class VariableKind:
    """One row of the table of variables.

    Attributes:
        name: the template of the variables' names.
        terminal: the first part of the name, a template, if the variables whose names begin with this part
            form a terminal in FMI 3.0; else "".
        owner_kind: the kind of owner that has such a variable: a key of ``owners.OWNER_KINDS``; "one" if
            a scene has at most one such variable.
        heading: the first words of the description.
        text: the rest of the description, a template.
        axis: x or y if the variable is a component of a vector, else "".
        unit: name of the unit; "" for a variable that is not a real number.
        causality: ``parameter``, ``input`` or ``output``.
        record_path: path of the value in use in the record of an instance, a template.
        when: the names of the conditions that a scene or an owner must all meet to have the variable.
        minimum: the smallest allowed value, a number or the name of a number of the scene; None for none.
        above: the limit that the value must exceed; None for none.
        maximum: the largest allowed value, a number or the name of a number of the scene; None for none.
        scene_path: path of a parameter in the scene, a template; None for inputs and outputs.
        given_path: path in the record, a template, of the given value of a parameter, if the record has this
            value beside the value in use; else None.
        stores_given_if: condition under which the record has ``given_path``; "" if it always has this path.
        derived: the rule by which the scene may derive the value; None for none.
        tunable: condition under which a parameter can be set during a run; "" if it never can.
        only_if_in_file: whether a scene that derives the value, because the file does not give it, lacks the
            parameter.
        value_if_not_in_file: the value of a parameter that a scene has although the file does not give it,
            such as one of two coefficients of friction; None if a scene without the value lacks the
            parameter.
        number_for_none: the number in the record for a value that the scene does not have.
        choices: name of the list of choices of an enumeration; "" for any other variable.
        smooth: whether there are derivatives with respect to the variable.
        hint: a sentence that tells users how to get the parameter into a scene; "" for none.
        feedthrough: whether an input acts on the output at once, not only through the state.
        nominal: the usual magnitude of the output, a key of ``nominal_values``; "" for none.
        rate_of: the field of the record's part ``output`` whose derivative over time the output is; "" for
            none.
        array: name of the array with all variables of the kind, in FMI 3.0 and in datasets; "" for none.
    """

    name: str
    text: str
    record_path: DataPath
    terminal: str = ""
    owner_kind: str = "one"
    heading: Heading = NO_HEADING
    axis: str = ""
    unit: str = ""
    causality: str = "output"
    when: tuple[str, ...] = ()
    minimum: float | str | None = None
    above: float | None = None
    maximum: float | str | None = None
    scene_path: DataPath | None = None
    given_path: DataPath | None = None
    stores_given_if: str = ""
    derived: Derived | None = None
    tunable: str = ""
    only_if_in_file: bool = False
    value_if_not_in_file: float | None = None
    number_for_none: float = 0.0
    choices: str = ""
    smooth: bool = True
    hint: str = ""
    feedthrough: bool = False
    nominal: str = ""
    rate_of: str = ""
    array: str = ""

    @cached_property
    def parts(self) -> NameParts:
        """The parts of the variables' name, with 0 for each number and "name" for the name of an owner."""
        return name_parts(self.name.format(n=0, of=0, name="name"))

    @cached_property
    def pattern(self) -> str:
        """The name that stands for all variables of the kind: `link[i].length`, `contact[k].<wall>.force`."""
        name = "<name>" if self.owner_kind in SIGNAL_OWNERS else "<wall>"
        return self.name.format(n=LETTERS.get(self.owner_kind, "i"), of="i", name=name)

    @cached_property
    def description(self) -> str:
        """The description of one variable of the kind, a template."""
        text = self.with_limit_text(f"{self.heading.text}: {self.text}" if self.heading.text else self.text)
        return text.replace("{axis}", self.axis)

    def general_description(self, texts: Mapping[str, Any]) -> str:
        """Return one description for all variables of the kind.

        Args:
            texts: word in braces → text for this scene and owner; the entry "general" is a table with the
                texts that hold for every owner, which are used in place of these.
        """
        general = {
            **texts,
            **texts.get("general", {}),
            "n": LETTERS.get(self.owner_kind, "i"),
            "axis": self.axis,
        }
        text = self.text.format_map(general)
        return self.with_limit_text(f"{self.heading.general}: {text}" if self.heading.general else text)

    def derivative(self, parameter: VariableKind) -> VariableKind:
        """Return the kind of derivatives of outputs of this kind with respect to parameters of another kind.

        The result has no unit; ``scene_variables.derivatives_of`` gives a unit to each variable of this kind.
        """
        output_pattern, parameter_pattern = self.pattern, parameter.pattern
        text = f"derivative of {output_pattern} with respect to {parameter_pattern}"
        return VariableKind(
            name=sensitivity_name(output_pattern, parameter_pattern),
            text=text,
            record_path=(),
            feedthrough=self.feedthrough,
        )

    def with_limit_text(self, text: str) -> str:
        """Return ``text`` with the limit ``above`` in words at its end, if there is one.

        FMI has no attribute for such a limit.
        """
        return text if self.above is None else f"{text}; must be > {self.above:g}"


SIGNAL_OWNERS = ("signal", "step")
"""The kinds of owners that belong to signals."""
GIVEN_ONLY = ("material", *SIGNAL_OWNERS)
"""The kinds of owners whose parameters are written to the record only if the scene gives them."""
LETTERS = {"point": "k", "contact": "k", "site": "j", "step": "k"}
"""Kind of owner → the letter for an owner's number in names and texts for all owners; i for other kinds."""


class Block(NamedTuple):
    """The kinds that one kind of owner has; all variables of an owner come before those of the next one."""

    owner_kind: str
    kinds: tuple[VariableKind, ...]


def block(
    owner_kind: str,
    *rows: VariableKind,
    prefix: str = "",
    is_terminal: bool = False,
    when: tuple[str, ...] = (),
    **extras: Any,
) -> Block:
    """Return the block of the kinds ``rows``, completed with what they have in common.

    Args:
        owner_kind: the kind of owner.
        rows: the kinds, with names that lack the prefix.
        prefix: the first part of all names, without the dot; "" for none.
        is_terminal: whether the variables of an owner form a terminal in FMI 3.0.
        when: names of conditions for all kinds, in addition to the conditions of each kind.
        extras: other attributes of ``VariableKind`` that all kinds have.
    """
    extras = {"owner_kind": owner_kind, "terminal": prefix if is_terminal else "", **extras}
    prefix_text = f"{prefix}." if prefix else ""
    return Block(
        owner_kind,
        tuple(
            replace(kind, name=prefix_text + kind.name, when=(*when, *kind.when), **extras) for kind in rows
        ),
    )


def row(
    name: str,
    unit: str,
    text: str,
    *,
    field: str = "",
    nominal: str = "",
    rate_of: str = "",
    array: str = "",
    feedthrough: bool = False,
    minimum: float | str | None = None,
    maximum: float | str | None = None,
    when: str = "",
) -> tuple[VariableKind, ...]:
    """Return the kinds of a row of ``record_block``.

    A row with {axis} stands for two kinds: for x, where {j} is 0, and for y, where {j} is 1. ``field`` is the
    dotted path of the field in its part of the record, if not the name, and ``when`` a condition beside those
    of the block; ``VariableKind`` explains the other arguments.
    """
    kinds = []
    for j, axis in enumerate(AXES if "{axis}" in name + text else ("",)):
        path = (field or name).replace("{axis}", axis).replace("{j}", str(j))
        kinds.append(
            VariableKind(
                name=name.replace("{axis}", axis),
                unit=unit,
                text=text,
                axis=axis,
                record_path=tuple(int(step) if step.isdecimal() else step for step in path.split(".")),
                nominal=nominal,
                rate_of=rate_of,
                array=array,
                feedthrough=feedthrough,
                minimum=minimum,
                maximum=maximum,
                when=(when,) if when else (),
            )
        )
    return tuple(kinds)


def input_row(name: str, text: str, *, field: str) -> tuple[VariableKind, ...]:
    """Return the kinds of a row of ``input_block``."""
    return row(name, "", text, field=field)


def input_block(
    part: str, owner_kind: str, prefix: str, *rows: tuple[VariableKind, ...], heading: Heading = NO_HEADING
) -> Block:
    """Return a block of inputs, with the unit and the key of [inputs] that INPUT_KINDS has for each name.

    ``record_block`` explains the arguments.
    """
    of_kind = record_block(part, owner_kind, prefix, *rows, heading=heading, causality="input")
    rows_of_inputs = [INPUT_KINDS[kind.name] for kind in of_kind.kinds]
    kinds = (
        replace(kind, unit=row_of_input.unit, when=(f"inputs.{row_of_input.key}",))
        for kind, row_of_input in zip(of_kind.kinds, rows_of_inputs, strict=True)
    )
    return of_kind._replace(kinds=tuple(kinds))


def record_block(
    part: str,
    owner_kind: str,
    prefix: str,
    *rows: tuple[VariableKind, ...],
    array: bool = False,
    **extras: Any,
) -> Block:
    """Return a block of kinds whose values are in one part of the record.

    Args:
        part: the part of the record.
        owner_kind: the kind of owner.
        prefix: the first part of the names.
        rows: the rows. {at}, the index of the owner, is appended to the path of a field that has neither {at}
            nor {next}, unless ``owner_kind`` is "one" or "slider".
        array: whether the values of all owners form an array with the name <owner_kind>.<name in the row>.
        extras: attributes that all kinds have, and further arguments of ``block``; the variables of an owner
            form a terminal unless ``is_terminal`` is False here.
    """
    kinds = [kind for kinds_of_row in rows for kind in kinds_of_row]
    has_no_index = owner_kind in ("one", "slider")
    for k, kind in enumerate(kinds):
        steps = (part, *kind.record_path)
        index = () if has_no_index or OWNER_AT in steps or NEXT_OWNER_AT in steps else (OWNER_AT,)
        array_name = f"{owner_kind}.{kind.name}" if array else kind.array
        kinds[k] = replace(kind, record_path=(*steps, *index), array=array_name)
    return block(owner_kind, *kinds, prefix=prefix, **{"is_terminal": True} | extras)


def owner_path(path: DataPath, owner: Mapping[str, Any]) -> DataPath:
    """Return a path in the record or in a scene: the template ``path`` with the values of ``owner``.

    Without values, the template is returned unchanged.
    """
    if not owner:
        return path
    steps: dict[str | int, Any] = {f"{{{word}}}": value for word, value in owner.items()}
    steps[NEXT_OWNER_AT] = owner.get("at", 0) + 1
    return tuple([steps.get(step, step) for step in path])
