// Functions of the page for the console of the browser, and for other pages that contain this page.

import { nearestText } from "../base/similar_names.js";
import { Changes } from "../scene/changes.js";

/** Return words for the fault with which a run ended, and for the part of the scene that causes the fault, if the kernel names a part. */
export function faultText({ status, part }, scene) {
  return [SHARED.kernel.STATUS_TEXT[status], scene.partsInWords[part - 1]].filter(Boolean).join(": ");
}

/** Return the end of a sentence on a run that a fault has stopped: at which time, and why. */
export function stopText(run, scene) {
  return `stopped at t = ${+run.reached.toPrecision(9)} s: ${faultText(run, scene)}`;
}

/** Return the object `chainImpact` of the page's window; `ask` is the function that sends a request to the worker (engine.js). */
export function consoleInterface(changes, ask) {
  return {
    get scene() {
      return changes.scene.name;
    },
    /** Return name → present value of each parameter, as text; the value of a choice is its name. */
    get parameters() {
      const values = changes.scene.parameters.map(({ name }) => [name, changes.valueOf(name)]);
      return Object.fromEntries(changes.texts(Object.fromEntries(values)));
    },
    /**
     * Simulate the scene with the changes `given`, name → value, but without the changes on the page; `output`: names of the outputs that
     * are wanted, all by default. Return {time, columns, impacts, statistics}. If the run stops before its end, throw an error with the
     * run's `status`, the `time` reached [s] and the `result` up to then.
     */
    async simulate(given = {}, { output } = {}) {
      const { scene } = changes;
      const values = new Changes(scene).with(given);
      if (output && !Array.isArray(output)) throw new TypeError("output must be a list of names");
      const unknown = output?.find((name) => !scene.columns.some((column) => column.name === name));
      const near = unknown && nearestText(unknown, scene.columns.map(({ name }) => name));
      if (unknown) throw new RangeError(`${unknown} is not an output${near}`);
      const result = await ask("rows", values, { names: output });
      const { time, columns, impacts, statistics, status, reached } = result;
      const named = impacts.map((impact) => ({ ...impact, wall: scene.wallNames[impact.wall] }));
      const run = { time, columns, impacts: named, statistics };
      if (status !== 0) {
        throw Object.assign(new Error(`the simulation ${stopText(result, scene)}`), { status, time: reached, result: run });
      }
      return run;
    },
    /** Change the parameters `given`, name → value, of the scene that the page shows; earlier changes stay. */
    show(given = {}) {
      changes.set(given);
    },
  };
}
