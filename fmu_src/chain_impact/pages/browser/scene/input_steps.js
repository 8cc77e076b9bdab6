// Inputs that the reader changed while the motion played: written as parts of the page's address, and as signals of a scene.

import { numberText } from "../base/format.js";

const MARK = "@"; // in an address, this mark follows the name of an input with steps

/** Return the inputs with steps as parts of an address: pairs [name and MARK, text of times [s] and values, such as 0.5:2,1:3]. */
export function inputStepTexts({ inputSteps }) {
  return Object.entries(inputSteps).map(([name, steps]) => [`${name}${MARK}`, steps.map((step) => step.map(numberText).join(":")).join()]);
}

/**
 * Return the contents of the parts of an address (`texts`: name → text): `inputSteps`, the inputs with steps, and `others`, all other
 * parts. An error tells which part is wrong.
 */
export function inputStepsIn(texts, changes) {
  const [others, inputSteps] = [{}, {}];
  for (const [key, text] of Object.entries(texts)) {
    if (!key.endsWith(MARK)) {
      others[key] = text;
      continue;
    }
    const name = key.slice(0, -MARK.length);
    if (!changes.scene.inputs.includes(name)) throw new RangeError(`${name} is not an input without a signal`);
    inputSteps[name] = stepsOf(name, text, changes);
  }
  return { others, inputSteps };
}

/** Return the pairs [time [s], value] that the text of the input `name` contains, such as 0.5:2,1:3. */
function stepsOf(name, text, changes) {
  const steps = text.split(",").map((step) => step.split(":"));
  const refused = steps.find(([time, value, ...more], k) => {
    const isLater = Number.isFinite(Number(time)) && Number(time) > (k > 0 ? Number(steps[k - 1][0]) : 0);
    return !isLater || !value?.trim() || more.length > 0;
  });
  if (refused) {
    const step = `${name}${MARK} = ${text}: ${refused.join(":")}`;
    throw new RangeError(`${step} must be a time [s], which is > 0 and > the time before it, a colon and a value`);
  }
  return steps.map(([time, value]) => [Number(time), changes.numberOf(name, value)]);
}

/**
 * Return name → contents of signals that drive all changed inputs. An input without steps in time gets a constant signal, because a joint
 * may not have a signal for its target angle and a number for its target velocity.
 */
export function inputSignals(changes) {
  const changed = changes.scene.inputs.filter((name) => changes.isChanged(name));
  return Object.fromEntries(changed.map((name) => {
    const all = [[0, changes.valueOf(name)], ...(changes.inputSteps[name] ?? [])];
    const [times, values] = [0, 1].map((part) => all.map((step) => step[part]));
    const form = all.length > 1 ? { form: "steps", times, values } : { form: "constant", value: values[0] };
    return [`held_${name.replaceAll(/\W+/g, "_")}`, { input: [name], ...form }];
  }));
}
