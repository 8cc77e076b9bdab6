// Functions that tests/pages/test_refusals.py runs in a page.
import { pageScene } from "../../../fmu_src/chain_impact/pages/browser/scene/page_scene.js";
import { completedFile } from "../../../fmu_src/chain_impact/pages/browser/scene/scene_file.js";

export const page = ([kit, contents]) => {
  try {
    const { record, contactPoints } = pageScene(kit, completedFile(contents, kit), []);
    return { words: [...new BigInt64Array(record.buffer)].map(String), touching: contactPoints.length };
  } catch (error) {
    if (error instanceof RangeError) return { refusal: error.message };
    throw error;
  } };
