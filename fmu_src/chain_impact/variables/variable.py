"""A variable of an FMU, and the data on it that an importer needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from chain_impact.scene.fast_values import LARGEST_NUMBER
from chain_impact.scene.rules.key_rules import Derived, allowed_text
from chain_impact.scene.texts.names import DataPath
from chain_impact.variables.kind import VariableKind, owner_path
from chain_impact.variables.owners import Owner

OBSERVED = ("output",), ("latest",)
"""The first steps of paths to those parts of the record that the kernel fills only when an output is read. A
real output in such a part has the variability "continuous" of FMI."""

UNLESS_SET = "; unless set: "
"""The words in the description of a parameter before the rule by which its value is derived."""


@dataclass(frozen=True, slots=True)
class Item:
    """One choice of an enumeration of the FMU; choices are numbered from 1, in the order of their list."""

    name: str
    description: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """One variable of the FMU.

    Attributes:
        kind: the variable's row in the table of variables.
        name: structured name, as in FMI 2.0, section 2.2.9.
        variability: ``fixed``, ``tunable``, ``discrete`` or ``continuous``.
        unit: name of the unit, for ``units.unit_of``; "" if the variable is not a real number.
        description: the description in the FMU, one line.
        record_path: path of the value in use in the record of an instance: ``("chain", "length", 2)``.
        given_path: path in the record of the given value of a parameter, if the record has this value beside
            the value in use (kernel/chain/inertia.py); else None.
        rule: the rule by which the scene derives the value; None if the scene does not derive it.
        scene_path: path of a parameter in the scene, for ``scene.with_values``; None for all other variables.
        minimum: the smallest allowed value; None for none.
        maximum: the largest allowed value; None for none.
        items: the choices of an enumeration; empty for any other variable.
        base_at_rest: whether the variable belongs to point 0, and this base is pinned and no input moves it.
        terminal: name of the variable's terminal in FMI 3.0; "" for none.
        texts: word in braces in templates → text or number that replaces the word.
    """

    kind: VariableKind
    name: str
    variability: str
    unit: str
    description: str
    record_path: DataPath
    given_path: DataPath | None = None
    rule: Derived | None = None
    scene_path: DataPath | None = None
    minimum: float | None = None
    maximum: float | None = None
    items: tuple[Item, ...] = ()
    base_at_rest: bool = False
    terminal: str = ""
    texts: Mapping[str, Any] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def from_kind(
        cls, kind: VariableKind, owner: Owner, texts: Mapping[Any, Any], **other_fields: Any
    ) -> Variable:
        """Return the variable of a kind that an owner has.

        ``texts`` has the texts for words in braces in templates, and the numbers that ``minimum`` and
        ``maximum`` name. ``other_fields`` are the other attributes of the variable; without ``variability``
        among them, it is ``continuous`` for a real output in a part of OBSERVED, else ``discrete``.
        """
        changing = kind.record_path[:1] in OBSERVED and kind.unit
        text, rule = kind.description.format_map(texts), other_fields.get("rule")
        return cls(
            kind=kind,
            name=kind.name.format_map(texts),
            # a value of a signal has the unit of the input that the signal drives
            unit=texts.get("unit", kind.unit) if kind.unit == "1" else kind.unit,
            description=f"{text}{UNLESS_SET}{rule.text}" if rule else text,
            record_path=owner_path(kind.record_path, owner.values),
            minimum=texts.get(kind.minimum, kind.minimum),
            maximum=texts.get(kind.maximum, kind.maximum),
            base_at_rest=owner.conditions.get("base_at_rest", False),
            terminal=kind.terminal and kind.terminal.format_map(texts),
            texts=texts,
            **{"variability": "continuous" if changing else "discrete"} | other_fields,
        )

    @property
    def type(self) -> str:
        """The type of the variable: ``real``, ``integer`` or ``enumeration``."""
        return "enumeration" if self.items else "real" if self.unit else "integer"

    @property
    def causality(self) -> str:
        """The causality in FMI: ``parameter``, ``input`` or ``output``."""
        return self.kind.causality

    @property
    def exclusive_minimum(self) -> float | None:
        """The limit that the value must exceed; None for no such limit."""
        return self.kind.above

    @property
    def kind_description(self) -> str:
        """One description for all variables of the kind in this scene."""
        text = self.kind.general_description(self.texts)
        return f"{text}{UNLESS_SET}{self.rule.text}" if self.rule else text

    @property
    def initial(self) -> str | None:
        """FMI's attribute ``initial``, which says how the start value is determined.

        It is ``exact`` for parameters, ``calculated`` for outputs, and None for inputs, which have no such
        attribute in FMI 2.0.
        """
        return {"parameter": "exact", "input": None, "output": "calculated"}[self.causality]

    @property
    def feedthrough(self) -> bool:
        """Whether an input acts on this output at once, not only through the state.

        An input acts at once on accelerations, except those of a base that cannot move; on forces, moments,
        peak forces of impacts and ``sticking``, because a torque changes the force of a rigid wall or of dry
        friction at once; and on derivatives of these outputs.
        """
        return self.kind.feedthrough and not self.base_at_rest

    @property
    def field(self) -> str:
        """The name of the field that has the value, without the part of the record: ``point_position``.

        The names of nested fields are joined by dots: ``friction.force``.
        """
        return ".".join(step for step in self.record_path[1:] if isinstance(step, str))

    @property
    def set_path(self) -> DataPath:
        """The path in the record of the value that users set; derivatives are with respect to this value.

        This is ``given_path`` for a parameter that a scene can derive, and for the initial position of a base
        that inputs move; else it is ``record_path``.
        """
        return self.given_path or self.record_path

    @property
    def index(self) -> tuple[int, ...]:
        """The index of the value in its field of the record, one number for each dimension of the field."""
        return tuple(step for step in self.record_path if isinstance(step, int))

    @property
    def allowed(self) -> str:
        """The allowed values in words, for example "a finite number > 0 [m]"."""
        if self.items:
            return "one of " + ", ".join(f"{n} ({item.name})" for n, item in enumerate(self.items, 1))
        limits = {"minimum": self.minimum, "above": self.exclusive_minimum, "maximum": self.maximum}
        return allowed_text(float, {"choices": None, "unit": self.unit, **limits})


class TableRow(NamedTuple):
    """A row of the FMU's table of variables: the data that reading and setting a variable needs.

    Indices are those of words of 8 bytes in the record.

    Attributes:
        name: the name of the variable.
        type: "real" or "integer"; an enumeration is an integer.
        word: index of the value in use, which reading returns.
        role: the variability of a parameter, else the causality.
        low: the lowest value that can be set.
        high: the highest value that can be set.
        allowed: the values that can be set, as text.
        set_word: index of the given value. A new value is written at ``word`` and at ``set_word``.
    """

    name: str
    type: str
    word: int
    role: str
    low: float
    high: float
    allowed: str
    set_word: int


def variable_row(variable: Variable, word: int, set_word: int) -> TableRow:
    """Return the row of a variable; ``TableRow`` explains ``word`` and ``set_word``."""
    role = variable.variability if variable.causality == "parameter" else variable.causality
    low: float
    low, high = -LARGEST_NUMBER, LARGEST_NUMBER
    if variable.items:
        low, high = 1, len(variable.items)
    elif variable.exclusive_minimum is not None:
        low = math.nextafter(variable.exclusive_minimum, math.inf)
    elif variable.minimum is not None:
        low = variable.minimum
    if variable.maximum is not None:
        high = variable.maximum
    type_ = "real" if variable.type == "real" else "integer"
    return TableRow(variable.name, type_, word, role, low, high, variable.allowed, set_word)
