// Functions that tests/pages/test_refusals.py runs in a page.
import { describe } from "../../../fmu_src/chain_impact/pages/browser/scene/model.js";
import { complete } from "../../../fmu_src/chain_impact/pages/browser/scene/scene_file.js";

export const page = ([kit, contents]) => {
  try {
    const { record, contactPoints } = describe(kit, complete(contents, kit), []);
    return { words: [...new BigInt64Array(record.buffer)].map(String), touching: contactPoints.length };
  } catch (error) {
    if (error instanceof RangeError) return { refusal: error.message };
    throw error;
  } };
