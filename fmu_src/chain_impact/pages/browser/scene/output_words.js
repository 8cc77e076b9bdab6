// The words for outputs in charts, and in the dialog for charts: there, outputs of the same quantity stand below one heading, one line for
// each axis or wall.

import { boxWallText, capitalized } from "./words.js";

const OF_OWNER = { point: "of a point", link: "of a link", joint: "of a joint", contact: "at a wall, of a point", wall: "at a wall" };
const WITHOUT_OWNER = { energy: "Energy", impact: "Impacts so far", slider: "Slider", solver: "Solver", tip: "Tip", base: "Base" };
const OF_AXIS = { x: "position", v: "velocity", a: "acceleration", y: "position" }; // first letter of a key such as vx → its quantity

/** Return the parts of an output's name: `owner`, its `number`, if any, and `wall`, `key` (in words) and `axis`, each "" without one. */
function outputParts(name) {
  const [, owner, number, rest] = /^(\w+)(?:\[(\d+)\])?\.(.+)$/.exec(name);
  const parts = rest.split(".");
  const wall = ["contact", "wall"].includes(owner) ? parts.shift() : "";
  const axis = /^[va]?[xy]$/.test(parts.at(-1)) ? parts.pop() : "";
  return { owner, number, wall, key: parts.map((part) => part.replaceAll("_", " ")).join(" "), axis };
}

/**
 * Return the words for an output: the `heading`, such as "Velocity of a point"; the `line` below it, such as x, or the floor; and the
 * `item` in this line, such as the number of the point. `valueOf`: a function from the name of a parameter to its value.
 */
export function outputWords(name, valueOf) {
  const { owner, number, wall: wallName, key, axis } = outputParts(name);
  const wall = boxWallText(wallName, valueOf) ?? wallName.replaceAll("_", " ");
  const heading = (of) => `${capitalized(key || OF_AXIS[axis[0]])} ${of}`;
  const line = axis.at(-1) ?? "";
  if (owner === "impact" && number) return { heading: heading("of an impact"), line, item: number };
  if (owner === "wall") return { heading: heading(OF_OWNER.wall), line, item: wall };
  if (number) return { heading: heading(OF_OWNER[owner]), line: wall || line, item: number };
  return { heading: WITHOUT_OWNER[owner] ?? capitalized(owner), line: "", item: [key, axis].filter(Boolean).join(" ") };
}

/** Return words for a wall in a sentence, such as "the floor", or "slider min" for slider_min. */
function wallWords(wall, valueOf) {
  const words = boxWallText(wall, valueOf);
  return words ? `the ${words}` : wall.replaceAll("_", " ");
}

/**
 * Return words for the curve of an output, such as "point 2 at the floor", or "joint 2, target angle". The words leave out the `quantity`
 * that all curves of the chart have. `valueOf`: a function from the name of a parameter to its value.
 */
export function outputCurveText(name, quantity, valueOf) {
  const { owner, number, wall, key, axis } = outputParts(name);
  const part = owner === "contact" ? "point" : owner;
  const own = number ? `${part} ${number}` : (WITHOUT_OWNER[owner] ?? owner).toLowerCase();
  const place = { contact: `${own} at ${wallWords(wall, valueOf)}`, wall: wallWords(wall, valueOf) }[owner] ?? own;
  const what = key || (axis.length > 1 ? OF_AXIS[axis[0]] : "");
  return [place, [what, axis.at(-1)].filter((word) => word && word !== quantity).join(" ")]
    .filter((word) => word && word !== quantity).join(", ");
}

/**
 * Return proposals for charts of a scene, pairs of words and names of outputs: those of the tip, of joints and of walls, each if the scene
 * has such outputs, at most `most` in one unit. `valueOf`: a function from the name of a parameter to its value.
 */
export function proposedOutputs(columns, links, most, valueOf) {
  const like = (pattern) => columns.map(({ name }) => name).filter((name) => pattern.test(name));
  const walls = [...new Set(like(/^contact.*\.force$/).map((name) => name.split(".")[1]))];
  const tip = `^point\\[${links}\\]\\.`;
  return [
    ["Path of the tip", like(new RegExp(`${tip}[xy]$`))],
    ["Velocity of the tip", like(new RegExp(`${tip}v[xy]$`))],
    ["Joint angles", like(/^joint\[\d+\]\.angle$/)],
    ["Forces in joints", like(/^joint\[\d+\]\.force\.[xy]$/)],
    ...walls.map((wall) => [`Forces at ${wallWords(wall, valueOf)}`, like(new RegExp(`^contact.*\\.${wall}\\.force$`))]),
  ].filter(([, names]) => names.length > 0 && names.length <= most);
}
