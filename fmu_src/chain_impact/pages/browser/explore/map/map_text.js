// The sentences on a map whose runs have ended, and on one of its runs.

import { textWithUnit } from "../../base/format.js";
import { lawText } from "../../scene/words.js";
import { presentlyShown } from "../parameters/parameter_fields.js";
import { areJumping } from "./map_colours.js";
import { withinText } from "./map_limit.js";
import { failureOf, outputIn, TOLD_OUTPUTS } from "./map_outputs.js";
import { POINTS, valuesAt } from "./map_rows.js";
import { quantityOf, scaledTo } from "./map_scales.js";

const BY_FINGER = "Tap a run to read it, and once more to open it.";
const BY_MOUSE = "Point at a run to read it, click to open it; or arrow keys, Enter.";

/**
 * Return sentences on a map: how many runs it has, what its marks mean, and how the reader opens a run. `limitField`: the field of the
 * limit; `hasRing`: whether the map has a ring; `hasSteps`: whether inputs have steps now; `isOfPresent`: whether the other parameters are
 * the present ones.
 */
export function doneText(shown, limitField, { hasRing, hasSteps, isOfPresent }) {
  const { points, rows, faults, results, seconds, output, fault } = shown;
  if (fault) return fault;
  if (rows < points) return `Stopped after ${rows} of ${points} rows. A pale run is not simulated: it has the colour of the nearest run.`;
  const grey = faults.size ? "; grey runs fail" : !results.includes(null) ? ""
    : `; grey runs have ${output.rigid ? "only impulses" : "no such impact"}`;
  const summary = points === POINTS
    ? `${points * points} runs in ${seconds.toPrecision(2)} s${grey}.`
    : `A preview of ${points}\u00a0×\u00a0${points} runs. Press Simulate for ${POINTS}\u00a0×\u00a0${POINTS}: a preview can miss jumps.`;
  const jumps = areJumping(shown) ? " Neighbouring runs jump: a single run is not representative." : "";
  const ring = hasRing ? " The ring is the present run." : "";
  const inputs = hasSteps ? " Inputs keep their start values." : "";
  const others = hasSteps || isOfPresent ? ring : " Other parameters have changed since then.";
  const pointer = matchMedia("(hover: none)").matches ? BY_FINGER : BY_MOUSE;
  return failureOf(shown) || `${summary}${jumps}${withinText(limitField, shown)}${inputs}${others} ${pointer}`;
}

/**
 * Return the values of both parameters of a run, in the `wordsOf` their names, its output, or why it has none, and its other important
 * outputs (TOLD_OUTPUTS).
 */
export function runText(shown, index, changes, wordsOf) {
  const { faults, outputs, output, scale, values, runs: { [index]: run }, results: { [index]: value } } = shown;
  const at = valuesAt(shown, index);
  const textOf = ([name, given]) => `${wordsOf(name)} = ${textWithUnit(given, presentlyShown(changes, name, { ...values, ...at }))}`;
  const unknown = output.rigid ? `only impulses with ${lawText(output.rigid)}` : "no such impact";
  const reason = faults.has(index) ? `the run fails: ${faults.get(index)}` : unknown;
  const outputText = ({ name, places }, number, unit) => `${quantityOf(name)} = ${places?.[number] ?? textWithUnit(number, unit)}`;
  const others = outputs.filter(({ name }) => run && name !== output.name && TOLD_OUTPUTS.includes(name))
    .map((one) => [one, outputIn(run, one)]).filter(([, number]) => number !== null)
    .map(([one, number]) => outputText(one, number, scaledTo(one, { ends: [number] })));
  const told = [value === null ? reason : outputText(output, value, scaledTo(output, scale)), ...others];
  return `${Object.entries(at).map(textOf).join(", ")}: ${told.join(", ")}`;
}
