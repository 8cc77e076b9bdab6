// Functions that tests/pages/test_curves.py runs in a page.
import { Kernel, runThrough } from "../../../fmu_src/chain_impact/pages/browser/solver/kernel.js";
import { motion } from "../../../fmu_src/chain_impact/pages/browser/solver/motion.js";

export const now = () => {
  const over = document.querySelector('#outputs-over-time .u-over').getBoundingClientRect();
  const line = document.querySelector('#outputs-over-time .now').getBoundingClientRect();
  return (line.left + line.width / 2 - over.left) / over.width;
};

/** Return the texts that the chart of outputs writes when it is drawn 300 pixels wide: [text, place relative to its width]. */
export const texts = async () => {
  const [writtenTexts, write] = [[], CanvasRenderingContext2D.prototype.fillText];
  const chart = document.querySelector("#outputs-over-time .chart");
  CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
    const over = chart.querySelector(".u-over");
    if (chart.contains(this.canvas)) writtenTexts.push([text, (x / devicePixelRatio - over.offsetLeft) / over.clientWidth]);
    return write.call(this, text, x, y);
  };
  chart.style.width = "300px";
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  CanvasRenderingContext2D.prototype.fillText = write;
  return writtenTexts;
};

export const course = async ({ module, file, kit, values }) => {
  const kernel = await Kernel.load(await compiled(module), sceneOf({ file, kit }));
  const { parts: { forces, impacts, rowTime } } = runThrough(motion(kernel, values));
  return impacts.map(({ point, wall, onset, end, peak_force }) => {
    const { force } = forces.find((row) => row.point === point && row.wall === wall);
    const within = force.filter((_, k) => rowTime[k] >= onset && rowTime[k] <= end);
    return [peak_force, Math.max(...within)];
  });
};

export const motionInPage = async ({ module, file, kit, curves }) => {
  const kernel = await Kernel.load(await compiled(module), sceneOf({ file, kit }));
  const { parts: { outputs, time } } = runThrough(motion(kernel, {}, { curves }));
  return { frames: time.length, rows: outputs.time.length,
    gap: Math.max(...outputs.time.slice(1).map((later, k) => later - outputs.time[k])), names: outputs.curves.map(({ name }) => name),
    largest: outputs.curves.map(({ values }) => values.reduce((a, b) => Math.max(a, b))) };
};

/** Return whether the chart of outputs lies in the window, where nothing covers it. */
export const inSight = () => {
  const box = document.querySelector("#outputs-over-time canvas")?.getBoundingClientRect();
  return Boolean(box) && [box.top + 1, box.bottom - 1].every((y) =>
    document.elementFromPoint(box.left + box.width / 2, y)?.closest("#outputs-over-time"));
};
