// Functions that tests/pages/test_kernel.py runs in a page.
import { Kernel, rowTimes, runThrough } from "../../../fmu_src/chain_impact/pages/browser/solver/kernel.js";

export const runEach = async ([module, contents, names, grid, stops, outputs]) => {
  const scene = sceneOf(contents);
  const words = outputs.map((name) => scene.columns.find((one) => one.name === name).word);
  const kernel = await Kernel.load(await compiled(module), scene);
  const given = [Float64Array.from(grid), Float64Array.from(stops), words];
  const found = runThrough(kernel.runEach({ "link[2].mass": 1.2 }, names, ...given));
  const after = runThrough(kernel.run({}, rowTimes(0.1, 0.01), scene.columns.slice(0, 1))).columns[0].length;
  return [btoa(String.fromCharCode(...new Uint8Array(found.buffer))), after];
};
