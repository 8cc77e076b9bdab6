"""Rankings: parameters and inputs in the order of their effect on one quantity of a run."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from chain_impact.deprecated import OlderName
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import EXPONENTS, Sensitivities
from chain_impact.scene.errors import names_matching
from chain_impact.study_data.ranking.effects import Effect
from chain_impact.study_data.ranking.quantity import quantity_named
from chain_impact.study_data.ranking.ranked_effects import RankedEffects

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from chain_impact.pictures.drawing.sizes import Size

# [1] an effect that is at most this, relative to ``RankedQuantity.size``, is round-off and counts as none
LEAST_EFFECT = 1e-12


@dataclass(frozen=True, repr=False)
class Ranking(RankedEffects):
    """Parameters and inputs in the order of their effect on a quantity, the largest effect first.

    Attributes:
        source: the name of the scene.
        quantity: the name of the quantity.
        value: the value of the quantity, in its ``unit``.
        unit: the unit of the quantity.
        where: words for the impact, the joint or the time at which the quantity has this value.
        effects: the effects of the parameters that have an effect, the largest first. Effects of parameters
            with the value 0 come after all others, because the step of a parameter that is 0 is arbitrary.
        without: the parameters without an effect.
        unknown: the parameters whose derivatives cannot be trusted; ``limits`` gives the reason.
        limits: sentences, as ``Result.sensitivity_limits``.
        left_out: exponents of contact laws that are not ranked, because the user did not name them in full. A
            change of an exponent changes the unit, and so the meaning, of the stiffness.
        value_in: a function that returns the value of the quantity in another run of the scene.
    """

    fill = OlderName("draw")

    def plot(self, path: str | os.PathLike[str] | None = None, *, size: Size | None = None) -> Figure | None:
        """Draw the largest effects as horizontal bars: to the right if the step makes the quantity larger.

        Args:
            path: a file; its suffix png, svg or pdf determines the kind. Without a file the figure is
                returned.
            size: width and height [inches]; with the height None, the contents determine the height.

        Raises:
            ValueError: when the size is not possible, or has no room for the bars.
            OSError: when the file cannot be written.
        """
        from chain_impact import pictures

        return pictures.ranking_picture(self).plot(path, size=size)

    def draw(self, figure: Figure) -> None:
        """Draw the bars on an empty figure.

        If the runs differ from all effects of the picture, the bars are the changes in these runs, because no
        effect to first order holds for the step.
        """
        from chain_impact import pictures

        pictures.ranking_picture(self).draw(figure)


def ranking_of(
    recording: Recording, sensitivities: Sensitivities, quantity: str, parameters: str | Sequence[str] = "*"
) -> Ranking:
    """Return the parameters of a recording in the order of their effects on a quantity.

    Args:
        recording: the recording, with impacts and outputs.
        sensitivities: the derivatives of the recording's outputs and impacts.
        quantity: see ``Result.ranking``.
        parameters: see ``Result.ranking``.

    Raises:
        SceneError: when the quantity does not exist, or the run does not have the quantity.
        UnknownNameError: when the recording has no derivatives for one of the parameters.
    """
    found_quantity = quantity_named(recording, sensitivities, quantity)
    names, units = list(sensitivities.parameters), sensitivities.units
    changes = found_quantity.slopes * np.array([sensitivities.step(name) for name in names])
    wanted_names = [parameters] if isinstance(parameters, str) else parameters
    fault = "not among simulate(sensitivities=[…])"
    matching_names = {
        name
        for pattern in wanted_names
        for name in names_matching(recording.name, pattern, names, fault, lambda _: None)
    }
    left_out = tuple(name for name in EXPONENTS if name in matching_names and name not in wanted_names)
    is_chosen = np.array([name in matching_names and name not in left_out for name in names])
    is_finite = np.isfinite(changes) & is_chosen
    has_no_effect = is_finite & (np.abs(changes) <= LEAST_EFFECT * found_quantity.size)
    at_zero = np.array([sensitivities.parameters[name] == 0.0 for name in names])
    order = [k for k in np.lexsort((-np.abs(np.where(is_finite, changes, 0.0)), at_zero)) if is_finite[k]]
    effects = tuple(
        Effect(
            names[k],
            sensitivities.parameters[names[k]],
            units[names[k]].removeprefix("1"),
            sensitivities.step_text(names[k]),
            float(changes[k]),
            float(found_quantity.slopes[k]),
        )
        for k in order
        if not has_no_effect[k]
    )
    names_without_effect, unknown_names = (
        tuple(np.array(names)[rows].tolist()) for rows in (has_no_effect, is_chosen & ~is_finite)
    )
    return Ranking(
        recording.name,
        quantity,
        found_quantity.value,
        found_quantity.unit,
        found_quantity.location_text,
        effects,
        names_without_effect,
        unknown_names,
        tuple(sensitivities.limits),
        left_out,
        value_in=found_quantity.value_in,
    )
