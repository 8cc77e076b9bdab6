// Functions that tests/pages/test_edit.py runs in a page.
import { describe } from "../../../fmu_src/chain_impact/pages/browser/scene/model.js";
import { structureOf } from "../../../fmu_src/chain_impact/pages/browser/scene/owners.js";
import { complete } from "../../../fmu_src/chain_impact/pages/browser/scene/scene_file.js";

export const recordInPage = ([kit, text, contents]) => {
  const file = complete(text ? TOML.parse(text) : contents, kit);
  const { record, parameters, columns, still } = describe(kit, file, []);
  const words = [...new BigInt64Array(record.buffer)].map(String);
  return { words, columns: columns.map(({ name, word, unit }) => [name, word, unit]), still,
    parameters: parameters.map(({ name, word, start }) => [name, word, String(start)]) };
};

export const structure = ([kit, contents]) => {
  const { sceneNumbers, lists, owners } = structureOf(complete(contents, kit), kit);
  return [sceneNumbers, lists, owners];
};

export const refusalInPage = ([kit, contents, more]) => {
  try {
    const file = complete(contents, kit);
    file.walls.push(...more);
    describe(kit, file, []);
    return "";
  } catch (error) {
    return error instanceof RangeError ? error.message : error.stack;
  }
};
