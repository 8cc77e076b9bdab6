// Completes and checks the contents of a scene file, by the data of keys in `scene_tables.py` and by rules that compare values. The kernel
// refuses further values that are valid alone, but not together.
// The twin in Python is `scene/checks/checks.py`.

import { unitText } from "../base/format.js";
import { pathText } from "../base/paths.js";
import { proposed } from "../base/similar_names.js";
import { inRadians, orDegrees } from "./angles.js";
import { BOX_WALLS, cornerOf, CORNERS, normalOf, SLIDER_STOPS, STOPS } from "./geometry.js";
import { keepEntryRules, keepFileRules, refuse, refuseWall, shown } from "./refusals.js";
import { completeSignals, signalsAsWritten } from "./signals.js";

const isTable = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/** Return whether a value has the type, the range and the form that its key demands. */
function keeps(value, { kind, minimum, above, maximum, choices, pattern }) {
  const is = {
    float: Number.isFinite,
    int: Number.isInteger,
    bool: (other) => typeof other === "boolean",
    str: (other) => typeof other === "string",
  };
  return is[kind](value) && !(value < minimum) && !(value <= above) && !(value > maximum) &&
    (!choices || choices.includes(value)) && (!pattern || new RegExp(pattern).test(value));
}

/** Refuse a file that lacks a required key; `path`: dotted path of the key. */
function refuseMissing(path, key, { meaning }) {
  refuse(path, "missing", { meaning: meaning === key ? "" : ` (${meaning})` });
}

/** Return the dotted names of all keys of scene files, without indices: "chain.links.mass". */
function namesOfKeys(keys, before = "") {
  return Object.entries(keys).flatMap(([key, { keys: inner = {} }]) => [before + key, ...namesOfKeys(inner, `${before}${key}.`)]);
}

class ContentsReader {
  constructor({ keys, laws, lawFile, inputs, motions }) {
    const units = [...inputs, ...motions].flatMap(({ rows }) => rows.map(({ name, unit }) => [name, unit]));
    Object.assign(this, { keys, lawFile, laws, units: new Map(units) });
  }

  table(data, keys, path) {
    if (!isTable(data)) refuse(path, "no_table", { value: shown(data) });
    const inner = (key) => (path ? `${path}.${key}` : key);
    const unknown = Object.keys(data).find((key) => !Object.hasOwn(keys, key));
    if (unknown !== undefined) this.#refuseUnknown(inner(unknown), keys);
    const contents = {};
    for (const [key, keyData] of Object.entries(keys)) {
      const given = data[key] ?? (keyData.isNeeded ? undefined : { table: {}, named: {}, tables: [] }[keyData.kind] ?? keyData.default);
      const isReplaced = keyData.orKey && (data[keyData.orKey] ?? undefined) !== undefined;
      if (given === undefined && (keyData.isNeeded || (keyData.orKey && !isReplaced))) refuseMissing(inner(key), key, keyData);
      if (given !== undefined && given !== null) contents[key] = this.value(given, this.#inUnitOf(contents.input, keyData), inner(key));
      if (key === "links" && keyData.kind === "tables") contents.links = this.#repeated(contents.links);
    }
    return contents;
  }

  /** Refuse an unknown key with the most similar key of any table; if no key is similar, the error lists the `keys` of its table. */
  #refuseUnknown(path, keys) {
    const near = proposed(path.replaceAll(/\[\d+\]/g, ""), namesOfKeys(this.keys));
    if (near) refuse(path, "near_key", { near });
    refuse(path, "unknown", { keys: Object.keys(keys).join(", ") });
  }

  value(given, keyData, path) {
    if (keyData.kind === "table") return this.table(given, keyData.keys, path);
    if (keyData.kind === "tables" || keyData.kind === "list") return this.#list(given, keyData, path);
    if (keyData.kind === "named") {
      if (!isTable(given)) refuse(path, "no_tables", { value: shown(given) });
      return Object.fromEntries(Object.entries(given).map(([name, table]) => [name, this.table(table, keyData.keys, `${path}.${name}`)]));
    }
    const value = inRadians(given, keyData.unit);
    const known = keyData.choices?.includes(this.laws[0]) ? { ...keyData, choices: this.laws } : keyData;
    if (!keeps(value, known)) refuse(path, "not_allowed", { value: shown(given), allowed: keyData.allowed + orDegrees(keyData.unit) });
    return value;
  }

  /**
   * Return the data of a key. If the key's values have the unit of the inputs that a signal drives, the data get the unit of the first of
   * these inputs (`names`).
   */
  #inUnitOf(names, keyData) {
    if (keyData.each) return { ...keyData, each: this.#inUnitOf(names, keyData.each) };
    if (!keyData.hasUnitOfInput) return keyData;
    const unit = this.units.get(names[0]?.replace(/\[\d+\]/, "[{n}]").replace(/^wall\.\w+/, "wall.{name}"));
    const text = unitText(unit ?? "1");
    return { ...keyData, unit, allowed: text ? `${keyData.allowed} [${text}]` : keyData.allowed };
  }

  #list(value, { kind, keys, entries, each, length, orTrue, orOne, meaning }, path) {
    const given = orOne && typeof value === "string" ? [value] : value;
    if (orTrue && typeof given === "boolean") return given ? ["*"] : [];
    const count = length === "links" ? this.links : length;
    const hasCount = typeof count === "number";
    if (isTable(given) && kind === "tables") refuse(path, "one_table", { name: path, others: "" });
    if (!Array.isArray(given)) {
      const expected = hasCount ? `, expected length ${count} (${meaning})` : "";
      refuse(path, "no_list", { value: shown(given), names: orTrue ? " of names, or true for all" : "", expected });
    }
    if (hasCount && given.length !== count) {
      const found = `${given.length} value${given.length === 1 ? "" : "s"}`;
      refuse(path, "length", { found, needed: `${count}${length === "links" ? ", one for each link" : ""} (${meaning})` });
    }
    if (entries && !(given.length >= entries[0] && given.length <= entries[1])) {
      refuse(path, "entries", { count: given.length, least: entries[0], most: entries[1] });
    }
    const read = (entry, k) =>
      (kind === "tables" ? this.table(entry, keys, `${path}[${k + 1}]`) : this.value(entry, each, `${path}[${k + 1}]`));
    return given.map(read);
  }

  /** Return one entry for each link: an entry with a `count` stands for so many equal links. */
  #repeated(links) {
    const all = links.flatMap(({ count = 1, ...link }) => Array.from({ length: count }, () => ({ ...link })));
    const [, most] = this.keys.chain.keys.links.entries;
    if (all.length > most) refuse("chain.links", "links", { count: all.length, most });
    this.links = all.length;
    return all;
  }
}

/** Return the contents of a scene file from its text; an error names the line with the fault. */
export function contentsIn(text) {
  try {
    return TOML.parse(text.replace(/^\ufeff/, ""));
  } catch (error) {
    throw new RangeError(`not valid TOML: ${error.message.split("\n")[0].replace(/^Invalid TOML document: /, "")} (at line ${error.line})`);
  }
}

/** Return the stops of joints as pairs: number of the joint, from 1, and key of its link, such as joint_min. */
export function stopsOf({ chain: { links } }) {
  return links.flatMap((link, k) => STOPS.filter((stop) => link[stop] !== undefined).map((stop) => [k + 1, stop]));
}

/** Return the names, among the walls, of a slider's existing stops. */
export function sliderStopsOf({ chain: { slider } }) {
  return Object.entries(SLIDER_STOPS).filter(([, key]) => slider?.[key] !== undefined).map(([name]) => name);
}

/** Return the points of links in the order of their numbers, each with the index of its `link` and its index (`entry`) among its points. */
export function sitesOf({ chain: { links } }) {
  return links.flatMap(({ points }, link) => points.map((site, entry) => ({ ...site, link, entry })));
}

/** Return the names of the existing walls, in the order of their numbers. */
export function wallsOf({ box, walls }) {
  return [...BOX_WALLS.filter((name) => name in box), ...walls.map(({ name }) => name)];
}

/** Return the numbers of the base and the link ends that may touch walls: all but a pinned base. */
export function movablePoints({ chain: { base, links } }) {
  return Array.from({ length: links.length + 1 }, (_, point) => point).slice(base === "pinned" ? 1 : 0);
}

const isAtBase = ({ link, x, y }) => link === 0 && x === 0 && y === 0;

/**
 * Return the numbers of the points that may touch walls: the link ends that the file lists (by default all ends that can move), and the
 * other points of links, except those that cannot move.
 */
export function touchingPoints(file) {
  const { chain: { base, links }, contact } = file;
  const movable = sitesOf(file).flatMap((site, s) => (base === "pinned" && isAtBase(site) ? [] : [links.length + 1 + s]));
  return [...(contact.points ?? movablePoints(file)), ...movable];
}

/**
 * Return the pairs of a point's number and a wall's name that can touch. A base that slides parallel to a wall cannot touch this wall, and
 * neither can a point of link 1 that lies at this base.
 */
export function pairsOf(file) {
  const { chain: { slider, links }, walls } = file;
  const sites = sitesOf(file);
  const slides = (point) => slider && (point === 0 || (point > links.length && isAtBase(sites[point - links.length - 1])));
  const isParallel = (name) => {
    const [nx, ny] = normalOf(name, walls.find((wall) => wall.name === name)?.angle);
    return Math.abs(nx * Math.cos(slider.angle) + ny * Math.sin(slider.angle)) < SHARED.kernel.PARALLEL_COSINE;
  };
  return touchingPoints(file).flatMap((point) =>
    wallsOf(file).filter((name) => !(slides(point) && isParallel(name))).map((name) => [point, name]));
}

/**
 * Return the contents of a scene file with all defaults, one entry for each link, and absolute angles in radians. Derived values are left
 * out. An error names the wrong key.
 */
export function completedFile(data, kit) {
  const file = new ContentsReader(kit).table(data, kit.keys, "");
  if ((file.contact.law_file || "") !== kit.lawFile) {
    const law = `contact.law_file = ${shown(file.contact.law_file)}`;
    throw new RangeError(`${law}: this page has no compiler; chain-impact explore makes a page with this law`);
  }
  completeAll(file, data, kit);
  file.outputs.sensitivities = []; // the page computes no derivatives
  return file;
}

/**
 * Return a path of a complete scene as text. A link has the index of its entry in the data of the file; the entry may stand for `count`
 * links.
 */
function textInFile(path, { chain: { links } }) {
  const [first, list, link, ...following] = path;
  if (list !== "links") return pathText(path);
  let last = -1;
  return pathText([first, list, links.findIndex(({ count = 1 }) => (last += count) >= link), ...following]);
}

/** Add the defaults that follow from other values, and refuse values that are valid alone, but not together. */
function completeAll(file, data, kit) {
  // the order is that of Python's checks, so that a file with several faults is refused for the same fault
  const textAt = (path) => textInFile(path, data);
  keepFileRules(file, { textAt, rules: SHARED.refusalRules.GIVEN });
  setWallAngles(file);
  setBodies(file, data);
  setAngles(file);
  checkMaterials(file);
  completeSignals(file.signals, kit.tables);
  checkContents(file, textAt);
  setStops(file, kit.keys.stops.keys);
}

/** Add the corners of a link that is a box to its points; remove the default table of a slider if the base is not on a slider. */
function setBodies({ chain }, data) {
  chain.links.forEach((link) => {
    const { shape, height, length } = link;
    if (shape === undefined) return;
    const corners = CORNERS.map((_, index) => {
      const [x, y] = cornerOf(index + 1, length, height);
      return { x, y, name: "", corner: index + 1 };
    });
    link.points = [...corners, ...link.points];
    delete link.shape;
  });
  if (chain.base !== "slider" && !data.chain.slider) delete chain.slider;
}

/** Return the contents of a complete scene as a file has them: without the corners of boxes, and without the default values of signals. */
export function asWritten(file) {
  const written = structuredClone(file);
  written.signals = signalsAsWritten(written.signals);
  written.chain.links.filter(({ height }) => height !== undefined).forEach((link) => {
    link.shape = "box";
    link.points = link.points.filter(({ corner }) => !corner);
  });
  return written;
}

/** Replace initial joint angles by absolute angles; if initial angular velocities are missing, they become 0. */
function setAngles({ initial, chain }) {
  let sum = 0;
  initial.angles ??= initial.joint_angles?.map((angle) => (sum += angle));
  delete initial.joint_angles;
  initial.angular_velocities ??= chain.links.map(() => 0);
}

/** Replace normals of walls by angles. */
function setWallAngles({ walls }) {
  walls.forEach((wall) => {
    wall.angle ??= Math.atan2(-wall.normal[0], wall.normal[1]) + 0;
    delete wall.normal;
  });
}

/** Add the constant defaults of the stops' contact law, if there are stops. */
function setStops(file, keys) {
  if (!stopsOf(file).length) return;
  for (const [key, { ofStops }] of Object.entries(keys)) {
    if (ofStops !== undefined) file.stops[key] ??= ofStops;
  }
}

/** Refuse a table contact.wall.… for a wall that does not exist. */
function checkMaterials(file) {
  const existingWalls = wallsOf(file);
  const strange = Object.keys(file.contact.wall).find((name) => !existingWalls.includes(name));
  if (strange !== undefined) refuseWall(`contact.wall.${strange}`, existingWalls);
}

/** Refuse contents that break a rule between several values, as Python does; sort the points of contact.points. */
function checkContents(file, textAt) {
  const { contact, inputs, chain, walls } = file;
  contact.points?.sort((a, b) => a - b); // sorted, because the order of points has no meaning
  keepEntryRules(file, {
    movable: movablePoints(file),
    walls: walls.length,
    reserved: [...BOX_WALLS, ...(stopsOf(file).length ? STOPS : []), ...(chain.slider ? Object.keys(SLIDER_STOPS) : [])],
    get reached() { // known only if the points are right, which an earlier rule checks
      return chain.slider ? pairsOf(file).map(([, name]) => name) : [];
    },
  }, textAt);
  keepFileRules(file, { textAt });
  const existingWalls = wallsOf(file);
  inputs.wall_motion.forEach((name, k) => {
    if (name !== "*" && !existingWalls.includes(name)) refuseWall(`inputs.wall_motion[${k + 1}]`, existingWalls, `= ${shown(name)} `);
  });
}
