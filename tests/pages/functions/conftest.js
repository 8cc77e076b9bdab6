// Functions that tests/pages/conftest.py runs in a page.
import { Kernel, rowTimes, runThrough } from "../../../fmu_src/chain_impact/pages/browser/solver/kernel.js";
import { textsOf } from "./in_pages.js";

export const runInPage = async ({ module, file, kit, values, stop, step }) => {
  const scene = sceneOf({ file, kit });
  const kernel = await Kernel.load(await compiled(module), scene);
  const times = rowTimes(stop, step);
  const run = runThrough(kernel.run(values, times, scene.columns));
  const impacts = run.impacts.map((impact) =>
    Object.fromEntries(Object.entries(impact).map(([name, value]) => [name, String(value)])));
  return { ...run, impacts, time: textsOf([run.time]), columns: textsOf(run.columns), names: scene.columns,
    partsInWords: scene.partsInWords };
};
