// The words that the page shows in place of the names of walls, contacts, inputs, parameters and numbers of signals.

// walls of a box → words for them, in general and if gravity points straight down
const OF_BOX = { x_min: "left wall", x_max: "right wall", y_min: "lower wall", y_max: "upper wall" };
const WITH_GRAVITY = { ...OF_BOX, y_min: "floor", y_max: "ceiling" };
// the first letter of the name of a base's quantity, as in x, vx, ax → the word for it
const OF_BASE = { x: "position", y: "position", v: "velocity", a: "acceleration" };

/** Return words with a capital letter at the beginning. */
export function capitalized(words) {
  return words[0].toUpperCase() + words.slice(1);
}

/**
 * Return the words for a wall of a box, which is the floor or the ceiling only if gravity points straight down; undefined for other walls.
 * `valueOf`: a function from the name of a parameter to its value.
 */
export function boxWallText(name, valueOf) {
  return (valueOf("gravity.x") === 0 && valueOf("gravity.y") < 0 ? WITH_GRAVITY : OF_BOX)[name];
}

/** Return the words for a contact law, such as "Zhang–Sharf (2009)"; any other name, such as that of a user's law, as it is. */
export function lawText(name) {
  return SHARED.laws[name]?.words ?? name;
}

/** Return the name of a scene as words: "Four link box" for FourLinkBox; a name that is no such word stays. */
export function sceneText(name) {
  return name.replace(/(?<=[a-z])[A-Z](?=[a-z])/g, (letter) => ` ${letter.toLowerCase()}`);
}

/** Return a sentence in which walls of the box, as in "at the wall y_min", have the words of `boxWallText`, as in "at the floor". */
export function withBoxWalls(sentence, valueOf) {
  return sentence.replace(/\bthe wall (\w+)/g, (all, name) => {
    const words = boxWallText(name, valueOf);
    return words ? `the ${words}` : all;
  });
}

/** Return the name of a contact's wall, or its words as a wall of a box; for a stop, only which end it is: min or max. */
export function wallText({ wall, boxWall }) {
  return boxWall ?? wall.replace(/^(joint|slider)_(?=(min|max)$)/, "");
}

/**
 * Return words for a contact: "point 2 at the floor"; for a stop of a joint also the number that the drawing has at the joint: "joint 3 at
 * max (point 2)". The number is at the end, which a narrow screen may cut.
 */
export function placeText(contact) {
  const [, joint] = /^joint (\d+)$/.exec(contact.what) ?? [];
  return `${contact.what} at ${contact.boxWall ? "the " : ""}${wallText(contact)}${joint ? ` (point ${joint - 1})` : ""}`;
}

/** Return the name of a point in the words for what touches, such as "point 5 (heel)"; undefined if it has no name, or is no point. */
export function pointName(what) {
  return /^point \d+ \((.+)\)$/.exec(what)?.[1];
}

/** Return what touches as short text: the name of a point, or its number; a joint or slider as it is. */
export function touchingPartText({ what }) {
  return pointName(what) ?? what.replace(/^point /, "");
}

/**
 * Return the words for an input: "Force on the tip, x" for tip.force.x, "Target angle of joint 2" for joint[2].target_angle, "Displacement
 * of the floor" for wall.y_min.displacement. `valueOf`: a function from the name of a parameter to its value.
 */
export function inputText(name, valueOf) {
  const [head, ...rest] = name.split(".");
  const inHead = { base: [OF_BASE[rest[0][0]], rest[0].at(-1)], wall: [rest[1]] }[head];
  const [key, axis] = inHead ?? rest;
  const wall = head === "wall" && boxWallText(rest[0], valueOf);
  const owner = wall ? `the ${wall}` : head === "wall" ? rest[0] : head.includes("[") ? head.replace(/\[(\d+)\]/, " $1") : `the ${head}`;
  const words = `${key.replaceAll("_", " ")} ${key === "force" ? "on" : "of"} ${owner}${axis ? `, ${axis}` : ""}`;
  return capitalized(words);
}

/** Return the words for a number of a signal: "push: time 1", or "push: value 1 at time 1" for the key value[1] of the signal push. */
export function signalText(signal, key) {
  const words = key.replaceAll("_", " ").replace(/\[(\d+)\]$/, "\u00a0$1");
  return `${signal}: ${words.replace(/^value(\u00a0\d+)$/, "$& at time$1")}`;
}

/** Return the words for a parameter: "Mass of link 1" for link[1].mass, "Initial angle of link 2", "Gravity, x", "Box, x_min". */
export function parameterText(name) {
  const [head, ...rest] = name.split(".");
  const key = rest.at(-1) ?? "";
  const words = ["gravity", "box"].includes(head) ? `${head}, ${key}` : partsText(head, rest.slice(0, -1), key);
  return capitalized(words);
}

/** Return the words for a key of an owner: "friction of wall ramp", "initial angle of link 1". */
function partsText(head, others, key) {
  const spaced = key.replaceAll("_", " ").replace("center", "centre");
  if (head === "initial") return `initial ${spaced.replace(/\[(\d+)\]$/, " of link $1")}`;
  const owners = head === "wall" ? [`wall ${others.join(" ")}`] : [head, ...others];
  return [spaced, ...owners.reverse().map((owner) => owner.replace(/\[(\d+)\]$/, " $1"))].join(" of ");
}
