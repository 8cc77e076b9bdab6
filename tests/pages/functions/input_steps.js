// Functions that tests/pages/test_input_steps.py runs in a page.
import { Kernel, runThrough } from "../../../fmu_src/chain_impact/pages/browser/solver/kernel.js";
import { stepsForKernel } from "../../../fmu_src/chain_impact/pages/browser/solver/motion.js";

export const run = async ({ module, file, kit, inputSteps, times, name }) => {
  const kernel = await Kernel.load(await compiled(module), sceneOf({ file, kit }));
  const wanted = kernel.scene.columns.filter((column) => column.name === name);
  const options = { inputSteps: stepsForKernel(kernel, inputSteps) };
  return Array.from(runThrough(kernel.run({}, Float64Array.from(times), wanted, options)).columns[0]);
};
