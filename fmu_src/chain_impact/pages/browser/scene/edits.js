// The edits of a scene file that the page's editor makes: of the base, links, points, walls and stops.

import { CORNERS, pointsOf, STOPS } from "./geometry.js";
import { movablePoints, stopsOf } from "./scene_file.js";

const NEW_WALL_DISTANCE = 0.5; // distance of a new wall below the chain, relative to the length of the longest link

export function setOrRemove(table, key, value) {
  if (value === undefined) delete table[key];
  else table[key] = value;
}

export function setOfLink(file, k, key, value) {
  const link = file.chain.links[k];
  setOrRemove(link, key, value);
  if (key === "height") setOrRemove(link, "shape", value === undefined ? undefined : "box");
  if (!stopsOf(file).length) file.stops = {}; // without a stop, the table [stops] must have no values
}

/**
 * Return a point of a link in a scene file. `link`: index from 0. `entry`: index from 0 among all points of the link; if the link is a box,
 * the first are its corners, for which a file has no entries and which this function cannot return.
 */
export function ownPoint({ chain: { links } }, link, entry) {
  return links[link].points[entry - (links[link].shape ? CORNERS.length : 0)];
}

export function removePoint({ chain: { links } }, link, entry) {
  links[link].points.splice(entry - (links[link].shape ? CORNERS.length : 0), 1);
}

export function moveToLink(file, link, entry, number) {
  const { chain: { links } } = file;
  if (!links[number - 1]) throw new RangeError(`the link of a point = ${number} must be 1 to ${links.length}`);
  const point = ownPoint(file, link, entry);
  removePoint(file, link, entry);
  links[number - 1].points.push(point);
}

/** Add a point to the last link, beside the middle of the link: to the left by a tenth of the link's length. */
export function addPoint({ chain: { links } }) {
  const { length, points } = links.at(-1);
  points.push({ x: length / 2, y: length / 10 });
}

/** Set the kind of the base, and remove all values that a base of this kind cannot have. */
export function setBase(file, base) {
  file.chain.base = base;
  if (base !== "slider") {
    delete file.chain.slider;
    delete file.initial.slider_velocity;
    file.inputs.slider_force = false;
  }
  if (base === "free") {
    STOPS.forEach((stop) => setOfLink(file, 0, stop, undefined));
    file.inputs.base_motion = false;
  } else {
    file.initial.velocity = [0, 0];
    if (base === "slider") file.inputs.base_motion = false;
  }
  keepPoints(file);
}

/** Remove from the file's list contact.points all points that do not exist or cannot move. */
function keepPoints(file) {
  const movable = movablePoints(file);
  file.contact.points &&= file.contact.points.filter((point) => movable.includes(point));
}

/** Add a link at the tip, in line with the last link and equal to it, but for the stops of a new link 2. */
export function addLink({ chain: { links }, initial, contact }) {
  const tip = links.length;
  links.push(structuredClone(links.at(-1)));
  // the new link 2 has no stops: the angles of joint 1 are from +x, but those of joint 2 are relative to link 1
  if (tip === 1) STOPS.forEach((stop) => delete links[tip][stop]);
  [initial.angles, initial.angular_velocities].forEach((list) => list.push(list.at(-1)));
  if (contact.points?.includes(tip)) contact.points.push(tip + 1);
}

export function removeLink(file, k) {
  [file.chain.links, file.initial.angles, file.initial.angular_velocities].forEach((list) => list.splice(k, 1));
  const { links } = file.chain;
  // if link 1 is removed, the next link becomes the first and has no stops, because its stops were relative to the removed link
  STOPS.forEach((stop) => setOfLink(file, 0, stop, k === 0 ? undefined : links[0][stop]));
  // the two ends of the removed link become one point, so all later points have lower numbers
  const points = file.contact.points?.map((point) => (point > k ? point - 1 : point));
  file.contact.points &&= [...new Set(points)];
  keepPoints(file);
}

/** Add a horizontal wall below the link ends at the start of the motion. */
export function addWall(file) {
  const { chain: { links }, initial, walls } = file;
  const points = pointsOf(initial.position, links.map(({ length }, k) => [length, initial.angles[k]]));
  const least = Math.min(...points.map(([, y]) => y));
  const names = new Set(walls.map(({ name }) => name));
  let number = 1;
  while (names.has(`wall${number}`)) number += 1;
  const y = least - (file.contact.radius ?? 0) - NEW_WALL_DISTANCE * Math.max(...links.map(({ length }) => length));
  walls.push({ name: `wall${number}`, point: [initial.position[0], Number(y.toPrecision(4))], angle: 0 });
}

export function removeWall(file, k) {
  const [{ name }] = file.walls.splice(k, 1);
  forget(file, name);
}

export function setBox(file, key, value) {
  setOrRemove(file.box, key, value);
  if (value === undefined) forget(file, key);
}

/** Remove the table contact.wall.… of a removed wall, which has its material, and the name of the wall in inputs.wall_motion. */
function forget({ contact, inputs }, name) {
  delete contact.wall[name];
  inputs.wall_motion = inputs.wall_motion.filter((other) => other !== name);
}
