// Keeps the reader's changes when a scene is edited: an edit may change the number of a link or point, and a changed variable stays with
// its owner.

import { valueInFile } from "../base/paths.js";
import { setOrRemove } from "../scene/edits.js";
import { CORNERS } from "../scene/geometry.js";
import { filledTemplate, structureOf } from "../scene/owners.js";
import { asWritten } from "../scene/scene_file.js";

/**
 * Return the `links` of a scene file, and as `sites` the points of all links: each with its `link`, its `index` in the link, and its
 * `entry` in the file or, for a corner of a link that is a box, the number of the corner. An edit changes indices, so links and entries,
 * as objects, identify links and points.
 */
export function partsOf({ chain: { links } }) {
  const entriesOf = ({ shape, points }) => [...(shape ? CORNERS.keys() : []), ...points];
  const sites = links.flatMap((link) => entriesOf(link).map((entry, index) => ({ link, index, entry })));
  return { links: [...links], sites };
}

/**
 * Return an owner of variables with the numbers that it has after an edit; undefined if the edit has removed it. `counts`: what the number
 * of the owner counts (`COUNT_NAMES` in scene_tables.py); `before`, `after`: results of `partsOf` for the scene before and after the edit.
 */
function ownerAfter(owner, counts, before, after) {
  const { n, at } = owner;
  const linkAt = (k) => after.links.indexOf(before.links[k]);
  const siteAt = (s) => after.sites.findIndex(({ link, entry }) =>
    entry === before.sites[s].entry && (typeof entry === "object" || link === before.sites[s].link));
  if (counts === "sites") {
    const site = after.sites[siteAt(at)];
    return site && { ...owner, n: site.index + 1, of: after.links.indexOf(site.link) + 1 };
  }
  if (!counts || n === 0) return owner; // point 0, the base, keeps its number
  const isLink = n <= before.links.length;
  const k = isLink ? linkAt(n - 1) : siteAt(n - 1 - before.links.length);
  return k < 0 ? undefined : { ...owner, n: k + 1 + (isLink ? 0 : after.links.length) };
}

/** Return the name of a field of the editor after an edit of the scene; undefined if the edit has removed its link or point. */
export function fieldAfter(name, before, after) {
  const [, kind, n, key] = /^(link|point)\[(\d+)\](.*)$/.exec(name) ?? [];
  if (!kind) return name;
  const owner = ownerAfter({ n: Number(n) }, kind, before, after);
  return owner && `${kind}[${owner.n}]${key}`;
}

/**
 * Return a function from the name of a variable before an edit of the scene to its name after the edit, undefined if its owner is removed;
 * the function returns other names as they are. `before`, `after`: results of `partsOf` for the two scenes.
 */
function namesAfter({ file }, kit, before, after) {
  const { owners } = structureOf(file, kit);
  const names = new Map();
  for (const { ownerKind, counts, rows } of [kit.parameters, kit.inputs, kit.motions, kit.outputs].flat()) {
    for (const owner of owners[ownerKind]) {
      const moved = ownerAfter(owner, counts, before, after);
      rows.forEach(({ name }) => names.set(filledTemplate(name, owner), moved && filledTemplate(name, moved)));
    }
  }
  return (name) => (names.has(name) ? names.get(name) : name);
}

/**
 * Let the signals of an edited scene drive the same inputs as before the edit, under their new names (`nameOf`); remove inputs that do not
 * exist any more, and signals without inputs. Return words for each removed signal and input.
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
 * Return the scene with edited contents, and the reader's changes in it:
 *
 * - `whole`, the complete file, and its `scene`, both without the reader's changes;
 * - `kept`, the changes that the edit keeps. The change of a parameter is dropped if the edit itself gives this parameter a value;
 * - `nameOf`, the function from a name before the edit to the name after it;
 * - `removed`, words for the signals, and the inputs of signals, that the edit removes.
 *
 * If the scene without the changes is impossible, `whole` and `scene` contain the changed values, and `kept` has only changes of inputs.
 *
 * @param before the result of `partsOf` for the contents before the edit.
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
    else if (path && valueInFile(file, path) === (items.length ? items[value - 1][0] : value)) {
      setOrRemove(valueInFile(file, path.slice(0, -1)), path.at(-1), valueInFile(scene.file, filePath));
      ofFile[after] = value;
    }
  }
  const steps = Object.fromEntries(Object.entries(inputSteps).map(([name, pairs]) => [nameOf(name), pairs]));
  const base = openIfPossible(file, open, Object.keys(ofFile));
  return { ...(base ?? edited), kept: { values: { ...(base && ofFile), ...ofInputs }, inputSteps: steps }, nameOf, removed };
}

/** Return the result of `open` for a complete file; undefined if the scene is refused, or lacks one of the parameters `names`. */
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
