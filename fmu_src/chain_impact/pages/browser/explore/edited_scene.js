// The changes of the reader in a scene that is edited: as far as the edit leaves their values, they stay changes, which can be reset.

import { setOrRemove } from "../scene/edits.js";
import { inFile } from "../scene/refusals.js";
import { asWritten } from "../scene/scene_file.js";

/**
 * Return `contents`, those of an edited scene file (as `complete` returns it) with the values before the changes of parameters, and
 * `values`, these changes: name → number. A change is left out, and its value stays in the contents, if the edit has replaced it.
 */
export function withoutChanges(file, { values, parameters, scene }) {
  const before = structuredClone(file);
  const kept = Object.entries(values).filter(([name, value]) => {
    const { filePath, items } = parameters.get(name);
    if (!filePath || inFile(file, filePath) !== (items.length ? items[value - 1][0] : value)) return false;
    setOrRemove(inFile(before, filePath.slice(0, -1)), filePath.at(-1), inFile(scene.file, filePath));
    return true;
  });
  return { contents: asWritten(before), values: Object.fromEntries(kept) };
}
