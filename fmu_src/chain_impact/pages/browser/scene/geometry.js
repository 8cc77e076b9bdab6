// The geometry of a scene for given values of its parameters: walls, points of links, names of stops.

/**
 * NORMALS: wall of the box → its inward normal. STOPS: the stops of a joint, whose names are keys of a link and names among the walls.
 * SLIDER_STOPS: name of a slider's stop among the walls → its key.
 */
export const { NORMALS, STOPS, SLIDER_STOPS } = SHARED.names;
/** The names of the walls of the box, in the order of their numbers. */
export const BOX_WALLS = Object.keys(NORMALS);
/** The corners of a box, in the order of their numbers: positions along the link and to its left, as fractions of length and height. */
export const { CORNERS } = SHARED.file;

/** Return the coordinates [m] of a corner of a box by its number, from 1: along the link, and to its left. */
export function cornerOf(number, length, height) {
  const [along, left] = CORNERS[number - 1];
  return [along * length, left * height];
}

/**
 * Return the coordinates of a point of a link, along the link and to its left, and its radius [m]; corners of a box follow from its length
 * and height.
 */
export function discOf({ link, entry, corner }, valueOf) {
  const of = `link[${link + 1}]`;
  if (!corner) return ["x", "y", "radius"].map((key) => valueOf(`${of}.point[${entry + 1}].${key}`));
  return [...cornerOf(corner, valueOf(`${of}.length`), valueOf(`${of}.height`)), valueOf("contact.radius")];
}

/** Return the value of a default that follows from others: a sum of products of values, divided by a number. */
export function sumOf({ terms, divisor }, valueOf) {
  const products = terms.map((factors) => factors.reduce((product, factor) => product * valueOf(factor), 1) / divisor);
  return products.reduce((sum, term) => sum + term, 0);
}

/** Return the words for a point in sentences: its number, and its name if `names` has one: "point 5 (heel)". */
export function pointText(names, point) {
  return names.has(point) ? `point ${point} (${names.get(point)})` : `point ${point}`;
}

/** Return the inward normal of a wall: a wall of the box is given by its name, another wall by its angle [rad]. */
export function normalOf(name, angle) {
  return NORMALS[name] ?? [-Math.sin(angle), Math.cos(angle)];
}

/** Return the positions [m] of the base and of the end of each link, from the lengths [m] and angles [rad] of the links. */
export function pointsOf(base, links) {
  return links.reduce((points, [length, angle]) => {
    const [x, y] = points.at(-1);
    return [...points, [x + length * Math.cos(angle), y + length * Math.sin(angle)]];
  }, [base]);
}

/** Return the free sides of the walls for the present parameters: name → normal and offset. */
export function wallsAt(scene, valueOf) {
  const sides = Object.entries(scene.walls).map(([name, wall]) => {
    if (valueOf(`box.${name}`) !== undefined) {
      const [nx, ny] = normalOf(name);
      return [name, { normal: [nx, ny], offset: (nx + ny) * valueOf(`box.${name}`) }];
    }
    const angle = valueOf(`wall.${name}.angle`);
    if (angle === undefined) return [name, wall];
    const [nx, ny] = normalOf(name, angle);
    return [name, { normal: [nx, ny], offset: nx * valueOf(`wall.${name}.x`) + ny * valueOf(`wall.${name}.y`) }];
  });
  return Object.fromEntries(sides);
}
