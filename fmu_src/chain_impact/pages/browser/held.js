// Inputs that the reader changed while the motion played: in a link, and as signals of a scene.

import { numberText } from "./changes.js";

const MARK = "@"; // behind the name of such an input in a link

/** Return the parts of a link: names, and texts with pairs of a time and a value. */
export function heldTexts({ held }) {
  return Object.entries(held).map(([name, steps]) => [`${name}${MARK}`, steps.map((step) => step.map(numberText).join(":")).join()]);
}

/** Return the held inputs in the parts of a link, and the other parts. An error says what is allowed. */
export function heldAmong(texts, changes) {
  const [others, held] = [{}, {}];
  for (const [key, text] of Object.entries(texts)) {
    if (!key.endsWith(MARK)) {
      others[key] = text;
      continue;
    }
    const name = key.slice(0, -MARK.length);
    if (!changes.scene.inputs.includes(name)) throw new RangeError(`${name} is no input without a signal`);
    held[name] = text.split(",").map((step) => {
      const [time, value] = step.split(":");
      if (!(Number(time) >= 0)) throw new RangeError(`${name} = ${step} must be a time >= 0 [s] and a value`);
      return [Number(time), changes.numberOf(name, value)];
    }).sort((a, b) => a[0] - b[0]);
  }
  return { others, held };
}

/** Return the signals of a scene with the held inputs: name → contents. */
export function heldSignals(changes) {
  return Object.fromEntries(Object.entries(changes.held).map(([name, steps]) => {
    const all = [[0, changes.valueOf(name)], ...steps];
    const [times, values] = [0, 1].map((part) => all.map((step) => step[part]));
    return [`held_${name.replaceAll(/\W+/g, "_")}`, { input: [name], form: "steps", times, values }];
  }));
}
