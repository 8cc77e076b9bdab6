"""A scene prepared for simulation: the scene, with data that are computed from the scene once and then kept.

A prepared scene has the candidates, and the variables of the FMU with their paths in the record of an
instance (kernel/record/); lists of variables are in the order of their value references. It makes new
instances, whose records have the parameters of the scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import cached_property
from typing import Any

import numpy as np

from chain_impact.compilation.compilers import AnyLinks, KernelScope
from chain_impact.kernel.record.counts import Counts
from chain_impact.kernel.record.fields import WORD
from chain_impact.scene.facts import SceneFacts
from chain_impact.scene.scene import Scene
from chain_impact.scene.signals import signal_inputs_of
from chain_impact.scene.texts.names import DataPath
from chain_impact.variables.filling import new_record, with_tangents
from chain_impact.variables.indices import (
    OutputIndices,
    first_word,
    indices_of,
    layout_of,
    output_indices,
    word_index,
)
from chain_impact.variables.scene_variables import derivatives_of, outputs_of, parameters_of, undriven_inputs
from chain_impact.variables.selection import differentiable_named, outputs_named
from chain_impact.variables.shared_data import shared_by_structure, shared_data_of
from chain_impact.variables.structure import Structure, structure_of
from chain_impact.variables.variable import TableRow, Variable, variable_row

KEPT_SELECTIONS = 64  # largest number of selections of outputs (names or patterns) whose indices are kept


class PreparedScene:
    """A scene and the data that follow from it; each property is computed at most once, at its first use.

    Attributes:
        scene: the scene.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.shared = scene, shared_data_of(scene)
        vars(self).update(self.shared.parts)

    def __eq__(self, other: object) -> bool:
        """Return whether ``other`` is a prepared scene with an equal scene."""
        return self.scene == other.scene if isinstance(other, PreparedScene) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[type[PreparedScene], tuple[Scene]]:
        """Pickle the scene only, because another process can compute the other data from it."""
        return type(self), (self.scene,)

    @shared_by_structure
    def structure(self) -> Structure:
        """The structure of the scene, which decides which variables exist."""
        return structure_of(self.scene)

    @shared_by_structure
    def candidates(self) -> list[tuple[int, int]]:
        """The candidates: pairs (number of a point or joint, index of a wall or stop in ``wall_names``).

        The number is 0 in the pair of a slider's stop.
        """
        return [(candidate["n"], candidate["wall"]) for candidate in self.structure.lists["candidates"]]

    @shared_by_structure
    def wall_names(self) -> tuple[str, ...]:
        """The names of walls and stops by their indices in the record (``SceneContents.wall_names``)."""
        return self.scene.wall_names

    @shared_by_structure
    def counts(self) -> Counts:
        """The counts that decide the layout of the record, such as the number of links."""
        return self.structure.counts

    @shared_by_structure
    def layout(self) -> np.dtype:
        """The NumPy type of an instance's record without tangent instances."""
        return layout_of(*self.counts)

    @shared_by_structure
    def output_layout(self) -> np.dtype:
        """The NumPy type of a row of ``Result.outputs`` with all outputs that change continuously."""
        return self.layout["output"]

    @shared_by_structure
    def parameters(self) -> list[Variable]:
        """The parameters of the FMU."""
        return list(parameters_of(self.scene, self.structure))

    @shared_by_structure
    def inputs(self) -> list[Variable]:
        """The inputs of the FMU."""
        return list(undriven_inputs(self.structure))

    @cached_property
    def signals_by_input(self) -> dict[str, str]:
        """Name of a quantity that a signal determines (``SignalInput.outputs``) → name of this signal."""
        return {
            name: signal_input.signal
            for signal_input in signal_inputs_of(self.scene)
            for name in signal_input.outputs
            if name
        }

    @shared_by_structure
    def outputs(self) -> list[Variable]:
        """The outputs of the FMU, without derivatives."""
        return list(self.outputs_without_derivatives.values())

    @shared_by_structure
    def outputs_without_derivatives(self) -> dict[str, Variable]:
        """Name → output of the FMU, without derivatives."""
        return outputs_of(self.structure)

    @cached_property
    def outputs_by_name(self) -> dict[str, Variable]:
        """Name → output of the FMU; the derivatives in the FMU are outputs, too."""
        return {variable.name: variable for variable in self.variables if variable.causality == "output"}

    @cached_property
    def units(self) -> dict[str, str]:
        """Name of a variable of the FMU → its unit."""
        return {variable.name: variable.unit for variable in self.variables}

    @shared_by_structure
    def continuous_outputs(self) -> list[Variable]:
        """The outputs that change continuously."""
        return [variable for variable in self.outputs if variable.record_path[0] == "output"]

    @cached_property
    def differentiated(self) -> list[Variable]:
        """The parameters and inputs with respect to which the FMU has derivatives: ``outputs.sensitivities``.

        Raises:
            UnknownNameError: when a name or pattern there matches no such parameter or input.
        """
        names = self.scene.outputs.sensitivities
        return differentiable_named(self, names) if names else []

    @cached_property
    def variables(self) -> list[Variable]:
        """All variables of the FMU; outputs come last."""
        return [
            *self.parameters,
            *self.inputs,
            *self.outputs,
            *derivatives_of(self.continuous_outputs, self.differentiated),
        ]

    @shared_by_structure
    def parameter_paths(self) -> dict[str, DataPath]:
        """Name of a parameter → the path of its value in the scene, which ``scene.with_values`` accepts.

        The value of an enumeration, such as ``contact.model``, is a name in the scene and a number in the
        FMU.
        """
        return {v.name: v.scene_path for v in self.parameters if v.scene_path is not None}

    @shared_by_structure
    def differentiable(self) -> dict[str, Variable]:
        """Name → parameter or input with respect to which there can be derivatives."""
        return {
            variable.name: variable for variable in (*self.parameters, *self.inputs) if variable.kind.smooth
        }

    @cached_property
    def start(self) -> np.ndarray:
        """An instance before initialization, with the values of parameters; the array cannot be changed."""
        start = self.new_instance()
        start.flags.writeable = False
        return start

    def word_of(self, variable: Variable) -> int:
        """Return the index, in words of 8 bytes of the FMU's record, of a variable's value in use."""
        return word_index(self.start.dtype, variable.record_path)

    def table_row(self, variable: Variable) -> TableRow:
        """Return the row of the FMU's table of variables for a variable."""
        words = (word_index(self.start.dtype, path) for path in (variable.record_path, variable.set_path))
        return variable_row(variable, *words)

    def start_text(self, variable: Variable) -> str:
        """Return the start value of a variable as the shortest text that is read back as the same number."""
        words = self.start.view(np.float64 if variable.type == "real" else np.int64)
        return repr(words[self.word_of(variable)].item())

    @shared_by_structure
    def output_index(self) -> dict[str, int]:
        """Name of an output that changes continuously → its index in a row of ``Result.outputs``."""
        return {
            variable.name: word_index(self.output_layout, variable.record_path[1:])
            for variable in self.continuous_outputs
        }

    @shared_by_structure
    def kernel_scope(self) -> KernelScope:
        """The scenes that a kernel for this scene can run."""
        return kernel_scope(self.scene)

    @shared_by_structure
    def output_words(self) -> np.ndarray:
        """The indices in the record of the numbers of a row of ``Result.outputs``, shape (W,)."""
        first = first_word(self.layout, "output")
        return np.arange(first, first + self.output_layout.itemsize // WORD)

    @shared_by_structure
    def output_indices(self) -> OutputIndices:
        """The indices in the record of all outputs of the scene, without derivatives."""
        return output_indices(self.structure, self.counts)

    def indices_named(self, wanted_names: str | Iterable[str]) -> OutputIndices:
        """Return the record's indices of the outputs with the names or patterns ``wanted_names``, in order.

        An output that several names or patterns match is returned once.

        Raises:
            UnknownNameError: when a name is not that of an output, or a pattern matches no output.
        """
        names = wanted_names if isinstance(wanted_names, str) else tuple(wanted_names)
        kept_indices = self._indices_by_names
        with suppress(KeyError, TypeError):  # TypeError: a name is no text, which ``outputs_named`` refuses
            return kept_indices[names]
        outputs = outputs_named(self, names)
        full_names = tuple(output.name for output in outputs)
        if len(kept_indices) >= KEPT_SELECTIONS:
            kept_indices.clear()
        indices = kept_indices.get(full_names)
        if indices is None:
            indices = indices_of(outputs, self.output_indices)
        kept_indices[names] = kept_indices[full_names] = indices
        return indices  # not what is kept, which another thread may have cleared

    @shared_by_structure
    def _indices_by_names(self) -> dict[str | tuple[str, ...], OutputIndices]:
        """Names or patterns → the indices of their outputs, from earlier calls of ``indices_named``."""
        return {}

    def series(self, outputs: np.ndarray) -> dict[str, np.ndarray]:
        """Return name of an output → its values over time, shape (T,).

        ``outputs`` are rows with all outputs that change continuously (``output_layout``), as in
        ``Result.outputs``.
        """
        return {
            variable.name: field_at(outputs, variable.record_path)[(..., *variable.index)]
            for variable in self.continuous_outputs
        }

    def new_instance(self, variables: Sequence[Variable] | None = None) -> np.ndarray:
        """Return an array with one record: an instance with the scene's parameters, before initialization.

        If the kernel computes derivatives, the last field of this record has the tangent instances.

        Args:
            variables: the parameters and inputs with respect to which the kernel computes derivatives; by
                default those with respect to which the FMU has derivatives.
        """
        variables = self.differentiated if variables is None else variables
        memory = new_record(self.scene, self.structure, self.shared)
        return with_tangents(memory, [variable.set_path for variable in variables]) if variables else memory


def field_at(outputs: Any, path: DataPath) -> Any:
    """Return the array of the field in ``Result.outputs`` that ``path``, a path in the record, leads to.

    Indices in the path are ignored, and so is the first step, "output".
    """
    for name in path[1:]:
        if isinstance(name, str):
            outputs = outputs[name]
    return outputs


def kernel_scope(scene: Scene) -> KernelScope:
    """Return the argument ``scope`` of ``kernel_library`` for a scene: the number of links, or all scenes.

    It is ``AnyLinks.GENERAL`` if inputs move the base or walls, signals drive inputs, or the fact
    "has_general_bodies" holds (scene/facts.py): other kernels have no code for these.
    """
    facts = SceneFacts(scene)
    is_general = scene.signals or facts["has_general_bodies"] or facts["has_motions"]
    return AnyLinks.GENERAL if is_general else len(scene.chain.links)


def as_prepared(source: Scene | PreparedScene) -> PreparedScene:
    """Return ``source`` itself if it is a prepared scene, else the prepared scene for it."""
    return source if isinstance(source, PreparedScene) else PreparedScene(source)
