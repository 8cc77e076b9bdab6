// The worker: runs the kernel a few milliseconds at a time, so that a newer request can replace an older one.

import { impactsUntil } from "../recording/frames.js";
import { touchingPartText, wallText } from "../scene/words.js";
import { Kernel, rowTimes } from "./kernel.js";
import { impactsOf, motion, stepsForKernel } from "./motion.js";

const MOST_BYTES = 500e6; // [byte] largest table of results that a request may ask for
const MESSAGE_INTERVAL = 15; // [ms] after this computing time the worker looks for messages

/** Let the worker receive the messages that wait; the returned promise is fulfilled afterwards. */
function pause() {
  return new Promise((go) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => go();
    port2.postMessage(null);
  });
}

/** Run through the communication points; return the results with `columns`: name → values of the outputs in `names`, or of all. */
function* rows(kernel, values, { names, inputSteps = {} }) {
  const outputs = kernel.scene.columns.filter(({ name }) => !names || names.includes(name));
  const time = (name) => values[name] ?? kernel.parameters.get(name).start;
  const [stopTime, step] = [time("simulation.stop_time"), time("simulation.step_size")];
  if (!(8 * (stopTime / step + 1) * (1 + outputs.length) <= MOST_BYTES)) {
    throw new RangeError("the table would be too large: choose longer steps, an earlier end or fewer outputs");
  }
  const times = rowTimes(stopTime, step);
  const result = yield* kernel.run(values, times, outputs, { inputSteps: stepsForKernel(kernel, inputSteps) });
  return { ...result, columns: Object.fromEntries(outputs.map(({ name }, k) => [name, result.columns[k]])) };
}

/**
 * Run once for each row of values (`each`, one row after the other) of the parameters `names`. Return in `rows` the words of the record
 * with the indices `words` at the end of each run, and in `firsts` the first impact of each run: name → value, or null without impacts. A
 * peak force is null at a stop of a joint, and where `impactsUntil` leaves none.
 */
function* study(kernel, values, { names, each, words }) {
  const endTime = values["simulation.stop_time"] ?? kernel.parameters.get("simulation.stop_time").start;
  const firstOf = (impacts, changed) => {
    const valueOf = (name) => changed[name] ?? kernel.parameters.get(name)?.start;
    const [first] = impactsUntil(impactsOf(impacts.slice(0, 1), kernel.scene, valueOf), endTime);
    return first ? {
      "impact[1].onset": first.onset,
      "impact[1].peak_force": first.atStop ? null : first.peak_force,
      "impact[1].place": `${touchingPartText(first)} ${wallText(first)}`,
    } : null;
  };
  return yield* kernel.runEach(values, names, each, endTime, words, firstOf);
}

/** Return the buffers of a result's times, runs and columns: the worker transfers these to the page, so that nothing is copied. */
function columnsOf({ time, columns = {}, rows: runs }) {
  return [time, runs, ...Object.values(columns)].filter(Boolean).map(({ buffer }) => buffer);
}

const KINDS = { motion, pinned: motion, rows, study };
const newest = {}; // kind of request → number of its newest request; older ones with `replaces` are given up
const kernels = {}; // kind of request → promise of a kernel; each kind has its own, because runs of several kinds take turns
const queues = {}; // kind of request → promise that the request before it has ended
let loaded; // the scene and the compiled module, when they have arrived

async function answer({ kind, number, values, options }) {
  kernels[kind] ??= Kernel.load(loaded.module, loaded.scene);
  const kernel = await kernels[kind];
  const isOld = () => options.replaces && newest[kind] !== number;
  const run = KINDS[kind](kernel, values, options);
  let began = performance.now();
  for (;;) {
    if (isOld()) return postMessage({ number, result: null });
    const step = run.next();
    if (step.done) return postMessage({ number, result: step.value }, columnsOf(step.value));
    if (performance.now() - began > MESSAGE_INTERVAL) {
      postMessage({ number, done: step.value });
      await pause();
      began = performance.now();
    }
  }
}

onmessage = ({ data }) => {
  if (data.kind === "scene") {
    loaded = data;
    return;
  }
  newest[data.kind] = data.number;
  const after = queues[data.kind] ?? Promise.resolve();
  queues[data.kind] = after.then(() => answer(data)).catch((error) => postMessage({ number: data.number, fault: error.message }));
};
