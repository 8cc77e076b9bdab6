// The geometry of a scene for given values of its parameters: walls, and points of links; and the names of stops.
// The twin in Python is `scene/half_planes.py`.

/**
 * NORMALS: wall of the box → its normal, which points inwards. STOPS: the stops of a joint: keys of a link, and names among the walls.
 * SLIDER_STOPS: name of a slider's stop among the walls → the slider's key.
 */
export const { NORMALS, STOPS, SLIDER_STOPS } = SHARED.names;
/** The names of the walls of the box, in the order of their numbers. */
export const BOX_WALLS = Object.keys(NORMALS);
/** The corners of a link that is a box, in the order of their numbers: along the link and to its left, relative to length and height. */
export const { CORNERS } = SHARED.file;

/** Return the coordinates [m] of a corner, by its number from 1, of a link that is a box: along the link, and to its left. */
export function cornerOf(number, length, height) {
  const [along, left] = CORNERS[number - 1];
  return [along * length, left * height];
}

/**
 * Return a point of a link as a disc: coordinates [m] along the link and to its left, and radius [m]. For a corner of a link that is a box,
 * the link's length and height give the coordinates, and contact.radius gives the radius.
 */
export function discOf({ link, entry, corner }, valueOf) {
  const of = `link[${link + 1}]`;
  if (!corner) return ["x", "y", "radius"].map((key) => valueOf(`${of}.point[${entry + 1}].${key}`));
  return [...cornerOf(corner, valueOf(`${of}.length`), valueOf(`${of}.height`)), valueOf("contact.radius")];
}

/**
 * Return the value of a default that follows from other parameters: the sum over `terms` of the products of their parameters, divided by
 * `divisor`.
 */
export function sumOf({ terms, divisor }, valueOf) {
  const products = terms.map((factors) => factors.reduce((product, factor) => product * valueOf(factor), 1) / divisor);
  return products.reduce((sum, term) => sum + term, 0);
}

/** Return the words for a point in sentences: its number, and its name if `names` has one: "point 5 (heel)". */
export function pointText(names, point) {
  return names.has(point) ? `point ${point} (${names.get(point)})` : `point ${point}`;
}

/** Return the unit normal of a wall towards its free side: of a wall of the box by its name, of any other wall by its angle [rad]. */
export function normalOf(name, angle) {
  return Object.hasOwn(NORMALS, name) ? NORMALS[name] : [-Math.sin(angle), Math.cos(angle)];
}

/** Return the positions [m] of the base and of the end of each link; `links`: [length [m], absolute angle [rad]] of each link. */
export function pointsOf(base, links) {
  return links.reduce((points, [length, angle]) => {
    const [x, y] = points.at(-1);
    return [...points, [x + length * Math.cos(angle), y + length * Math.sin(angle)]];
  }, [base]);
}

/** Return the positions [m] of the base and of the end of each link at the start; the parameters give the position `base` by default. */
export function startOf({ links }, valueOf, base = [valueOf("initial.x") ?? 0, valueOf("initial.y") ?? 0]) {
  const numbers = Array.from({ length: links }, (_, k) => k + 1);
  return pointsOf(base, numbers.map((link) => [valueOf(`link[${link}].length`), valueOf(`initial.angle[${link}]`)]));
}

/** Return the positions [m] of the points of links at the start; `positions`: those of the base and of the end of each link. */
export function sitesAt(positions, sites, valueOf) {
  return sites.map((site) => {
    const [x, y] = discOf(site, valueOf);
    const angle = valueOf(`initial.angle[${site.link + 1}]`);
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const [x0, y0] = positions[site.link];
    return [x0 + cos * x - sin * y, y0 + sin * x + cos * y];
  });
}

/** Return the radius [m] of the point with the number `point`: its own radius for a point of a link, `contact.radius` for a link end. */
export function radiusOf({ sites, links }, valueOf, point) {
  const site = sites[point - links - 1];
  return (site ? discOf(site, valueOf)[2] : valueOf("contact.radius")) ?? 0;
}

/** Return name of a wall → unit normal and offset [m] of its free side n·p ≥ offset, for the present parameters. */
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
