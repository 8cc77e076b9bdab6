// Functions that tests/pages/test_kernel.py runs in a page.
import { motion } from "../../../fmu_src/chain_impact/pages/browser/solver/motion.js";
import { Changes } from "../../../fmu_src/chain_impact/pages/browser/scene/changes.js";
import { Kernel, rowTimes, runThrough } from "../../../fmu_src/chain_impact/pages/browser/solver/kernel.js";

export const runEach = async ([module, contents, names, grid, endTime, outputs]) => {
  const scene = sceneOf(contents);
  const words = outputs.map((name) => scene.columns.find((column) => column.name === name).word);
  const kernel = await Kernel.load(await compiled(module), scene);
  const rows = runThrough(kernel.runEach({ "link[2].mass": 1.2 }, names, Float64Array.from(grid), endTime, words)).rows;
  const after = runThrough(kernel.run({}, rowTimes(0.1, 0.01), scene.columns.slice(0, 1))).columns[0].length;
  return [btoa(String.fromCharCode(...new Uint8Array(rows.buffer))), after];
};

export const memoryOfRuns = async ([module, contents]) => {
  const scene = sceneOf(contents);
  const kernel = await Kernel.load(await compiled(module), scene);
  const times = rowTimes(0.6, 0.01);
  const asked = [["contact.restitution"], Float64Array.of(0.5, 0.7), 0.6];
  const study = () => runThrough(kernel.runEach({}, ...asked, [scene.layout.status]));
  const values = (k) => ({ "contact.restitution": 0.3 + k / 2000 });
  const once = (k) => runThrough(kernel.run(values(k), times, scene.columns.slice(0, 3)));
  const size = () => kernel.exports.memory.buffer.byteLength;
  study();
  const [first, before] = [once(500), size()];
  for (let k = 0; k < 1000; k += 1) if (k % 50) once(k); else study();
  return [before, size(), String(first.columns) === String(once(500).columns)];
};

export const motionOf = async ([text, contents]) => {
  const scene = sceneOf(contents);
  const kernel = await Kernel.load(await compiled(text), scene);
  const { parts, status } = runThrough(motion(kernel, {}));
  const { time, view, anchor, pin, energies, forces, stops, radius, peakForce, drawn } = parts;
  return { status, time: [...time], view, anchor, pin, energies: Object.keys(energies), radius,
    loads: drawn.loads.map(({ n, columns: { x, y } }) => [n, Math.min(...x), Math.max(...y)]),
    stops, peakForce, forces: forces.map(({ point, wall }) => [point, wall]) };
};

export const statusOfRun = async ([text, contents, changes]) => {
  const scene = sceneOf(contents);
  const kernel = await Kernel.load(await compiled(text), scene);
  let values;
  try {
    values = new Changes(scene).with(changes);
  } catch (error) {
    if (!(error instanceof RangeError)) throw error;
    return error.message;
  }
  return runThrough(kernel.run(values, [0, 0.01], [])).status;
};
