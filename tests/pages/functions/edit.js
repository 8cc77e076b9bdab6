// Functions that tests/pages/test_edit.py runs in a page.
import { pageScene } from "../../../fmu_src/chain_impact/pages/browser/scene/page_scene.js";
import { structureOf } from "../../../fmu_src/chain_impact/pages/browser/scene/owners.js";
import { completedFile } from "../../../fmu_src/chain_impact/pages/browser/scene/scene_file.js";

export const recordInPage = ([kit, text, contents]) => {
  const file = completedFile(text ? TOML.parse(text) : contents, kit);
  const { record, parameters, columns, still } = pageScene(kit, file, []);
  const words = [...new BigInt64Array(record.buffer)].map(String);
  return { words, columns: columns.map(({ name, word, unit }) => [name, word, unit]), still,
    parameters: parameters.map(({ name, word, start }) => [name, word, String(start)]) };
};

export const structure = ([kit, contents]) => {
  const { sceneNumbers, lists, owners } = structureOf(completedFile(contents, kit), kit);
  return [sceneNumbers, lists, owners];
};

export const refusalInPage = ([kit, contents, more]) => {
  try {
    const file = completedFile(contents, kit);
    file.walls.push(...more);
    pageScene(kit, file, []);
    return "";
  } catch (error) {
    return error instanceof RangeError ? error.message : error.stack;
  }
};
