// Functions that tests/pages/test_refused_start.py runs.
import { overlapOf, startText } from "../../../fmu_src/chain_impact/pages/browser/explore/refused_start.js";

export const depths = ({ contents, values }) => {
  const scene = sceneOf(contents);
  const starts = Object.fromEntries(scene.parameters.map(({ name, start }) => [name, start]));
  const status = SHARED.kernel.STARTS_INSIDE_WALL;
  return scene.pairs.map(([, wall], k) =>
    [wall, overlapOf({ status, part: k + 1 }, scene, (name) => values[name] ?? starts[name]).depth]);
};

export const startTextOf = ({ contents, part }) => {
  const scene = sceneOf(contents);
  const status = SHARED.kernel.STARTS_INSIDE_WALL;
  return startText({ status, part: scene.partsInWords.indexOf(part) + 1 }, scene);
};
