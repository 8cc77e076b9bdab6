// The reader's changes in a scene that is edited: a change whose value the edit leaves stays a change, which can be reset.

import { inFile } from "../base/paths.js";
import { setOrRemove } from "../scene/edits.js";
import { asWritten } from "../scene/scene_file.js";

/** Return whether entries of a list can have other indices in the edited list: one is removed, or the corners of a box are. */
function isShifted(before, edited) {
  return edited.length < before.length || edited[0]?.corner !== before[0]?.corner;
}

/** Return whether a path of `file`, an edited scene file, can lead to another link, wall or point than in `scene`. */
function leadsElsewhere(file, { scene, path }) {
  return path.some((step, k) => {
    const [before, edited] = [scene.file, file].map((whole) => inFile(whole, path.slice(0, k)));
    return typeof step === "number" && (!edited || isShifted(before, edited));
  });
}

/**
 * Return `contents`, those of an edited scene file (as `complete` returns it) with the values before the changes of parameters, and
 * `values`, these changes: name → number. A change is left out, and its value stays in the contents, if the edit has replaced the
 * value, or if the index in its path can stand for another link, wall or point.
 */
export function withoutChanges(file, { values, parameters, scene }) {
  const before = structuredClone(file);
  const kept = Object.entries(values).filter(([name, value]) => {
    const { filePath: path, items } = parameters.get(name);
    if (!path || leadsElsewhere(file, { scene, path }) || inFile(file, path) !== (items.length ? items[value - 1][0] : value)) return false;
    setOrRemove(inFile(before, path.slice(0, -1)), path.at(-1), inFile(scene.file, path));
    return true;
  });
  return { contents: asWritten(before), values: Object.fromEntries(kept) };
}
