"""The check of the references in a model description and of its model structure (FMI 2.0.4, 2.2.8).

The model structure lists outputs, derivatives and the unknowns at the start, with the variables on which they
depend.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import pairwise
from xml.etree.ElementTree import Element

from chain_impact.fmu.check_variables import DescribedVariable
from chain_impact.fmu.findings import NAMED_VARIABLES, Finding
from chain_impact.fmu.versions import is_fmi_2
from chain_impact.text import names_text

OUTPUT_LIST, DERIVATIVE_LIST, INITIAL_LIST = "Outputs", "Derivatives", "InitialUnknowns"
_FMI_3_ELEMENTS = {
    OUTPUT_LIST: "Output",
    DERIVATIVE_LIST: "ContinuousStateDerivative",
    INITIAL_LIST: "InitialUnknown",
}
"""Name of a list in FMI 2.0 → name in FMI 3.0 of each element that replaces the list."""
_OUTSIDE_CAUSALITIES = ("input", "independent", "parameter", "structuralParameter")


class ModelStructure:
    """The references to variables in a model description: in its structure, derivatives and array sizes.

    A reference is the variable's index, from 1, in FMI 2.0, and its value reference in FMI 3.0.
    """

    def __init__(self, root: Element, variables: Sequence[DescribedVariable]) -> None:
        """Read the references in a model description."""
        self.variables = variables
        self.is_fmi_2 = is_fmi_2(root.get("fmiVersion"))
        self.key = "index" if self.is_fmi_2 else "valueReference"
        numbers = map(str, range(1, len(variables) + 1))
        references = numbers if self.is_fmi_2 else [variable.reference for variable in variables]
        self.by_reference = dict(zip(references, variables, strict=True))
        self.lists: dict[str, list[Element]] = {}
        for node in root.findall("ModelStructure/*"):
            unknowns = node.findall("Unknown") if self.is_fmi_2 else [node]
            self.lists.setdefault(node.tag, []).extend(
                unknown_node for unknown_node in unknowns if unknown_node.get(self.key)
            )

    def references_in(self, name: str) -> list[str]:
        """Return the references in a list of the model structure.

        ``name`` is the name of the list in FMI 2.0, also for a description of FMI 3.0.
        """
        nodes = self.lists.get(name if self.is_fmi_2 else _FMI_3_ELEMENTS[name], [])
        return [node.attrib[self.key] for node in nodes]

    def missing_variable_faults(self) -> Iterator[Finding]:
        """Yield a fault for each reference to a variable that does not exist."""
        index_text = f"an index from 1 to {len(self.by_reference)}"
        reference_text = index_text if self.is_fmi_2 else "the value reference of a variable"
        for variable in self.variables:
            targets = [("Dimension", "valueReference", size) for size in _sizes(variable)]
            if "derivative" in variable.attributes:
                targets.append(("derivative", "derivative", variable.attributes["derivative"]))
            for path, key, target in targets:
                if target not in self.by_reference:
                    yield Finding(
                        f"{key} = {target!r} must be {reference_text}",
                        variable=variable.name,
                        attribute=path,
                    )
        for path, node in self._nodes():
            if node.attrib[self.key] not in self.by_reference:
                fault = f"{self.key} = {node.attrib[self.key]!r} must be {reference_text}"
                yield Finding(fault, attribute=path.partition(",")[0])
            for target in sorted(set(_dependency_texts(node)) - self.by_reference.keys()):
                yield Finding(f"{target!r} must be {reference_text}", attribute=path)

    def findings(self) -> Iterator[Finding]:
        """Yield the faults of a model structure that has no ``missing_variable_faults``, which it needs.

        An unknown may be missing, superfluous, listed twice or in the wrong place; a dependency may be wrong,
        and so may the kind of a variable that gives the size of an array.
        """
        variables, derivatives = self.by_reference, set(self.references_in(DERIVATIVE_LIST))
        states = {variables[reference].attributes.get("derivative", "") for reference in derivatives} - {""}
        outputs = {reference for reference in variables if variables[reference].causality == "output"}
        start = {
            reference for reference in outputs | states | derivatives if not variables[reference].is_exact
        }
        start |= {
            reference for reference in variables if variables[reference].causality == "calculatedParameter"
        }
        clocked = {reference for reference in variables if "clocks" in variables[reference].attributes}
        rates = {reference for reference in variables if "derivative" in variables[reference].attributes}
        yield from self._completeness_faults(OUTPUT_LIST, outputs, outputs, "each output")
        yield from self._completeness_faults(
            DERIVATIVE_LIST, (), rates, "variables with the attribute derivative"
        )
        required_text = (
            "each output, state and derivative that is calculated at the start, each calculatedParameter"
        )
        yield from self._completeness_faults(INITIAL_LIST, start - clocked, start | clocked, required_text)
        for name, nodes in self.lists.items():
            path = f"ModelStructure/{name}"
            yield from repeated_findings((node.attrib[self.key] for node in nodes), self.key, path)
            # only FMI 2.0 has a list of this name; FMI 3.0 requires no order of initial unknowns
            if name == INITIAL_LIST:
                yield from _order_faults(self.references_in(name), path)
        for path, node in self._nodes():
            yield from self._dependency_faults(path, node, states)
        for variable in self.variables:
            for size in map(variables.__getitem__, _sizes(variable)):
                kinds = size.causality, size.attributes.get("variability")
                if size.type != "UInt64" or not {"structuralParameter", "constant"}.intersection(kinds):
                    text = f"its size is {size.name}, which must be UInt64, constant or a structuralParameter"
                    yield Finding(text, variable=variable.name, attribute="Dimension")

    def _completeness_faults(
        self, name: str, needed_names: Collection[str], allowed_names: set[str], requirement: str
    ) -> Iterator[Finding]:
        """Yield a fault for all variables that a list lacks, and one for all that the list must not have.

        Args:
            name: the name of the list in FMI 2.0.
            needed_names: references that must be listed.
            allowed_names: references that may be listed.
            requirement: words for the variables that belong into the list.
        """
        listed_names = set(self.references_in(name))
        for verb, wrong_names in (
            ("lacks", set(needed_names) - listed_names),
            ("must not have", listed_names - allowed_names),
        ):
            if wrong_names:
                names = names_text(
                    [
                        self.by_reference[reference].name
                        for reference in self.by_reference
                        if reference in wrong_names
                    ],
                    NAMED_VARIABLES,
                )
                text = f"{verb} {names}: it lists {requirement}, and nothing else"
                yield Finding(
                    text, attribute=f"ModelStructure/{name if self.is_fmi_2 else _FMI_3_ELEMENTS[name]}"
                )

    def _dependency_faults(self, path: str, node: Element, states: Collection[str]) -> Iterator[Finding]:
        # The dependencies of event indicators are for debugging only, and FMI 3.0 (table 23) does not say on
        # which variables they may depend. So any variable is allowed, also outputs.
        is_for_debugging = node.tag == "EventIndicator"
        depends, is_initial = _dependency_texts(node), INITIAL_LIST[:-1] in path
        yield from repeated_findings(depends, self.key, path)
        if self.is_fmi_2:
            yield from _order_faults(depends, path)
        for name in depends:
            variable = self.by_reference[name]
            is_state = not states or name in states or variable.attributes.get("variability") == "discrete"
            if not (
                variable.causality in _OUTSIDE_CAUSALITIES
                or (variable.is_exact if is_initial else is_state)
                or is_for_debugging
            ):
                known_text = "known at the start" if is_initial else "an input, a parameter or a state"
                yield Finding(f"{name} is {variable.name}, which is not {known_text}", attribute=path)
        kinds = node.get("dependenciesKind")
        if kinds is not None and len(kinds.split()) != len(depends):
            text = f"there are {len(depends)} dependencies, and {len(kinds.split())} in dependenciesKind"
            yield Finding(text, attribute=path)
        for kind in sorted(set((kinds or "").split()) - {"dependent", "constant"}) if is_initial else ():
            yield Finding(f"dependenciesKind = {kind!r} is not allowed at the start", attribute=path)

    def _nodes(self) -> Iterator[tuple[str, Element]]:
        """Yield each unknown of the model structure: its path with its reference, and its element."""
        for name, nodes in self.lists.items():
            for node in nodes:
                yield f"ModelStructure/{name}, {self.key} {node.attrib[self.key]}, dependencies", node


def _sizes(variable: DescribedVariable) -> list[str]:
    """Return the value references of the variables that give sizes of an array.

    Sizes that are plain numbers are left out.
    """
    return [
        size.attrib["valueReference"]
        for size in variable.node.iter("Dimension")
        if size.get("valueReference")
    ]


def _dependency_texts(node: Element) -> list[str]:
    return (node.get("dependencies") or "").split()


def _order_faults(numbers: Sequence[str], path: str) -> Iterator[Finding]:
    """Yield a fault for the first of the ``numbers`` that is smaller than the number before it, if any."""
    for earlier_number, later_number in pairwise(numbers):
        if int(later_number) < int(earlier_number):
            yield Finding(f"{later_number} must stand before {earlier_number}", attribute=path)
            return


def repeated_findings(texts: Iterable[str], text_kind: str, path: str) -> list[Finding]:
    """Return a finding for each text that occurs more than once in ``texts``.

    The finding names the text by ``text_kind``, such as ``name``, and has ``path`` as its attribute.
    """
    return [
        Finding(f"{text_kind} = {text!r} is listed {count} times", attribute=path)
        for text, count in Counter(texts).items()
        if count > 1
    ]
