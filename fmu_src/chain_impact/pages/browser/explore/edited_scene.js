// The reader's changes when a scene is edited: each changed variable stays with its link or point, whose number the edit may change.

import { inFile } from "../base/paths.js";
import { setOrRemove } from "../scene/edits.js";
import { CORNERS } from "../scene/geometry.js";
import { filled, structureOf } from "../scene/owners.js";
import { asWritten } from "../scene/scene_file.js";

/**
 * Return the links of a scene file as it is written, and its points: each with its link, its index there, and its `entry` in the file or
 * the number of a corner. An edit changes the numbers of links and points, but the entries stay the same objects.
 */
export function partsOf({ chain: { links } }) {
  const entriesOf = ({ shape, points }) => [...(shape ? CORNERS.keys() : []), ...points];
  const sites = links.flatMap((link) => entriesOf(link).map((entry, index) => ({ link, index, entry })));
  return { links: [...links], sites };
}

/** Return an owner of variables with its numbers after an edit; undefined if the edit has removed it. `counts`: see `kit.py`. */
function ownerAfter(owner, counts, before, after) {
  const { n, at } = owner;
  const linkAt = (k) => after.links.indexOf(before.links[k]);
  const siteAt = (s) => after.sites.findIndex(({ link, entry }) =>
    entry === before.sites[s].entry && (typeof entry === "object" || link === before.sites[s].link));
  if (counts === "sites") {
    const site = after.sites[siteAt(at)];
    return site && { ...owner, n: site.index + 1, of: after.links.indexOf(site.link) + 1 };
  }
  if (!counts || n === 0) return owner; // the base is point 0 before and after an edit
  const isLink = n <= before.links.length;
  const k = isLink ? linkAt(n - 1) : siteAt(n - 1 - before.links.length);
  return k < 0 ? undefined : { ...owner, n: k + 1 + (isLink ? 0 : after.links.length) };
}

/** Return a function from the name of a variable before an edit of a scene to its name afterwards; undefined if the owner is removed. */
function namesAfter({ file }, kit, before, after) {
  const { owners } = structureOf(file, kit);
  const names = new Map();
  for (const { ownerKind, counts, rows } of [kit.parameters, kit.inputs, kit.motions, kit.outputs].flat()) {
    for (const owner of owners[ownerKind]) {
      const moved = ownerAfter(owner, counts, before, after);
      rows.forEach(({ name }) => names.set(filled(name, owner), moved && filled(name, moved)));
    }
  }
  return (name) => (names.has(name) ? names.get(name) : name);
}

/**
 * Let signals drive the same inputs as before, as far as these still exist; remove signals without inputs. Return words for the removed
 * signals.
 */
function keepSignals(contents, nameOf, open) {
  const { scene: { inputs, still } } = open({ ...contents, signals: {} });
  const there = new Set([...inputs, ...still]);
  return Object.entries(contents.signals).flatMap(([name, signal]) => {
    const before = [signal.input].flat();
    const [kept, lost] = [true, false].map((isKept) => before.filter((input) => there.has(nameOf(input)) === isKept));
    signal.input = kept.map(nameOf);
    if (!kept.length) delete contents.signals[name];
    return kept.length ? lost.map((input) => `${input} of signal ${name}`) : [`signal ${name}`];
  });
}

/**
 * Return the scene of edited contents, with the reader's changes: `whole` and `scene`, which `open` returns for contents with the values
 * before the changes; the changes `kept`; `nameOf`, the function from a name before the edit to the name after it; and words for
 * the signals, and the inputs of signals, that are `removed`. A value that the edit has replaced is not a change. If the scene is not
 * possible without the changes, only changes of inputs stay changes.
 *
 * @param before from `partsOf`, for the contents before the edit.
 */
export function editedScene(contents, before, { scene, parameters, values, inputSteps }, { kit, open }) {
  const nameOf = namesAfter(scene, kit, before, partsOf(contents));
  const removed = Object.keys(contents.signals).length ? keepSignals(contents, nameOf, open) : [];
  const edited = open(contents);
  const paths = new Map(edited.scene.parameters.map(({ name, filePath }) => [name, filePath]));
  const [file, ofInputs, ofFile] = [structuredClone(edited.whole), {}, {}];
  for (const [name, value] of Object.entries(values)) {
    const [after, { filePath, items }] = [nameOf(name), parameters.get(name)];
    const path = paths.get(after);
    if (path === null) ofInputs[after] = value;
    else if (path && inFile(file, path) === (items.length ? items[value - 1][0] : value)) {
      setOrRemove(inFile(file, path.slice(0, -1)), path.at(-1), inFile(scene.file, filePath));
      ofFile[after] = value;
    }
  }
  const steps = Object.fromEntries(Object.entries(inputSteps).map(([name, pairs]) => [nameOf(name), pairs]));
  const base = openIfPossible(file, open, Object.keys(ofFile));
  return { ...(base ?? edited), kept: { values: { ...(base && ofFile), ...ofInputs }, inputSteps: steps }, nameOf, removed };
}

/** Return the result of `open` for a complete file, if the scene is possible and has parameters of all `names`; else undefined. */
function openIfPossible(file, open, names) {
  try {
    const opened = open(asWritten(file));
    const known = new Set(opened.scene.parameters.map(({ name }) => name));
    return names.every((name) => known.has(name)) ? opened : undefined;
  } catch (error) {
    if (error instanceof RangeError) return undefined;
    throw error;
  }
}
