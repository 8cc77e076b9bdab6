// The structure of a scene: its facts and lists, and the conditions, counts and owners of variables that follow from them by the
// tables of `owners.py`.

import { mapped } from "../base/mapped.js";
import { range } from "../base/range.js";
import { BOX_WALLS, STOPS } from "./geometry.js";
import { holds, numberIn } from "./rules.js";
import { pairsOf, sitesOf, sliderStopsOf, stopsOf, touchingPoints, wallsOf } from "./scene_file.js";
import { drivenBy } from "./signals.js";

/** Return the structure of a scene, as `structure.py`, and the parts of the scene from which it follows. */
export function structureOf(file, kit) {
  const [stops, existingWalls, sites, sliderStops, reached] = [stopsOf, wallsOf, sitesOf, sliderStopsOf, pairsOf].map((of) => of(file));
  const mayTouch = (existingWalls.length > 0 ? reached : touchingPoints(file)).length > 0;
  const lines = mayTouch ? file.walls.map(({ name }) => name) : [];
  const wallNames = [...BOX_WALLS, ...lines, ...(stops.length ? STOPS : []), ...sliderStops];
  const pairs = reached.map(([point, name]) => [point, wallNames.indexOf(name)]);
  const parts = { file, driven: drivenBy(file, kit.tables), sites, mayTouch, sliderStops, stops, existingWalls, wallNames, pairs };
  const lists = listsOf(parts);
  const known = withConditions(factsOf(parts, lists), lists, kit);
  return { ...parts, lists, known, owners: mapped(kit.owners, (row) => ownersIn(row, known, lists)) };
}

/** Return the lists of a scene, see `owners.py`. */
function listsOf({ file: { chain, walls, inputs }, driven, sites, sliderStops, stops, existingWalls, wallNames, pairs }) {
  const { STOP_CODES } = SHARED.kernel;
  return {
    links: chain.links.map(({ joint_friction: friction }, k) => {
      const jointed = chain.base !== "free" || k > 0;
      return { jointed, has_friction: jointed && friction > 0 };
    }),
    sites: sites.map(({ link, entry, corner = 0, name }) => ({ link, entry, corner, label: name })),
    candidates: [
      ...pairs.map(([n, wall]) => ({ n, wall, name: wallNames[wall], stop: 0, at_joint: false })),
      ...stops.map(([n, stop]) => ({ n, wall: wallNames.indexOf(stop), stop: STOP_CODES[stop], at_joint: true })),
      ...sliderStops.map((name) => ({ n: 0, wall: wallNames.indexOf(name), name, stop: STOP_CODES[name], at_joint: false })),
    ],
    walls: wallNames.map((name, number) =>
      ({ name, exists: existingWalls.includes(name), touched: pairs.some(([, wall]) => wall === number) })),
    lines: walls.map(({ name }) => ({ name })),
    moving_walls: wallNames.filter((name) =>
      existingWalls.includes(name) && inputs.wall_motion.some((other) => other === "*" || other === name)).map((name) => ({ name })),
    signals: driven.map(({ name, input }) => ({ name, input })),
    steps: driven.filter(({ signal }) => signal.form === "steps").flatMap(({ name, input, signal, first }) =>
      signal.times.map((_, entry) => ({ name, input, entry, knot: first + entry }))),
  };
}

/** Return the facts of a scene, see `owners.py`. */
function factsOf({ file, driven, mayTouch, sliderStops, stops, existingWalls, pairs }, lists) {
  const { chain: { base, links, slider }, contact, inputs, outputs } = file;
  const hasOwnFriction = Object.values(contact.wall).some(({ friction, static_friction: least }) => (friction ?? least) !== undefined);
  return {
    ...flags(inputs, "inputs"),
    ...flags(outputs, "outputs"),
    always: true,
    free: base === "free",
    pinned: base === "pinned",
    slider: base === "slider",
    skewed: links.some(({ center_of_mass_offset: offset }) => offset !== 0),
    contact_friction: mayTouch && existingWalls.length > 0 && (contact.friction > 0 || contact.static_friction > 0 || hasOwnFriction),
    joint_friction: lists.links.some(({ has_friction }) => has_friction),
    slider_friction: slider?.friction > 0,
    own_stop_law: Boolean(file.stops.model),
    has_limits: slider?.force_limit !== undefined || links.some((link) => link.joint_torque_limit !== undefined),
    pairs: pairs.length,
    stops: stops.length,
    slider_stops: sliderStops.length,
    knots: driven.reduce((sum, { knots }) => sum + knots, 0),
  };
}

/** Return the values of a table under their dotted keys; a list of names counts as its length. */
function flags(table, name) {
  return Object.fromEntries(Object.entries(table).map(([key, value]) => [`${name}.${key}`, value.length ?? value]));
}

/** Return the facts with the conditions of the scene, the lengths of its lists and its counts. */
function withConditions(facts, lists, { conditions, counts }) {
  const known = { ...facts, ...mapped(lists, ({ length }) => length) };
  const valueOf = (name) => known[name];
  for (const [name, rule] of Object.entries(conditions)) known[name] = holds(rule, valueOf);
  return { ...known, ...mapped(counts, (rule) => numberIn(rule, valueOf)) };
}

/**
 * Return the owners of one row of the table of owners: the members of its list that meet its rule `has`, with their numbers and
 * conditions.
 */
function ownersIn({ list, count, has, numbers, conditions }, known, lists) {
  const found = new Map();
  (lists[list] ?? range(numberIn(count, (name) => known[name])).map(() => ({}))).forEach((member, order) => {
    const here = { ...known, ...member, order };
    const valueOf = (name) => here[name];
    if (!holds(has, valueOf)) return;
    const owner = { ...member, ...mapped(numbers, (rule) => numberIn(rule, valueOf)) };
    for (const [name, rule] of Object.entries(conditions)) owner[name] = here[name] = holds(rule, valueOf);
    const key = [owner.n, owner.of, owner.name].join();
    if (!found.has(key)) found.set(key, owner);
  });
  return [...found.values()];
}

/** Return a template with the words of an owner filled in. */
export function filled(text, { n, of, name }) {
  const before = n > 1 ? `link ${n - 1}` : "the base";
  return text.replaceAll("{n}", n).replaceAll("{of}", of).replaceAll("{name}", name).replaceAll("{before}", before);
}

/** Return all rows of the groups for each owner of the group's kind; `has`: whether the owner meets the row's conditions. */
export function rowsOfOwners(groups, { owners, known }) {
  return groups.flatMap(({ ownerKind, rows }) => owners[ownerKind].flatMap((owner) => {
    const here = { ...known, ...owner };
    return rows.map((row) =>
      ({ ...row, ownerKind, owner, name: filled(row.name, owner), has: row.when.every((condition) => here[condition]) }));
  }));
}
