// The owners of variables, as in `shape.py`: points, walls, contacts and others, with the conditions for variables.

import { BOX_WALLS, STOPS } from "./geometry.js";
import { movablePoints, pairsOf, sitesOf, sliderStopsOf, stopsOf, touchingPoints, wallsOf } from "./scene_file.js";
import { drivenBy } from "./signals.js";

/** Return the numbers from 0 to length − 1. */
export const range = (length) => Array.from({ length }, (_, k) => k);

/** Return the parts of a scene on which its variables and its record depend. */
export function partsOf(file, { tables }) {
  const { chain: { base, links, slider }, walls, contact, inputs } = file;
  const count = links.length;
  const [points, stops, existingWalls] = [contact.points ?? movablePoints(file), stopsOf(file), wallsOf(file)];
  const [sites, sliderStops] = [sitesOf(file), sliderStopsOf(file)];
  const reached = pairsOf(file);
  const mayTouch = (existingWalls.length > 0 ? reached : touchingPoints(file)).length > 0;
  const wallNames = [...BOX_WALLS, ...(mayTouch ? walls.map(({ name }) => name) : []), ...(stops.length ? STOPS : []), ...sliderStops];
  const pairs = reached.map(([point, name]) => [point, wallNames.indexOf(name)]);
  const materials = Object.values(contact.wall);
  const rubs = mayTouch && existingWalls.length > 0 && (contact.friction > 0 || contact.static_friction > 0 ||
    materials.some(({ friction, static_friction: least }) => friction !== undefined || least !== undefined));
  const firstJoint = base === "free" ? 2 : 1;
  const joints = range(count).map((k) => k + 1).filter((joint) => joint >= firstJoint);
  const rubbingJoints = joints.filter((joint) => links[joint - 1].joint_friction > 0);
  const movingWalls = wallNames.filter((name) =>
    existingWalls.includes(name) && inputs.wall_motion.some((other) => other === "*" || other === name));
  const candidates = [
    ...pairs,
    ...stops.map(([joint, stop]) => [joint, wallNames.indexOf(stop)]),
    ...sliderStops.map((stop) => [0, wallNames.indexOf(stop)]),
  ];
  const driven = drivenBy(file, tables);
  const hasFriction = rubs || rubbingJoints.length > 0 || slider?.friction > 0;
  const parts = {
    file, driven, points, sites, mayTouch, sliderStops, stops, existingWalls, wallNames, pairs, candidates, rubbingJoints,
    hasFriction, movingWalls, joints,
  };
  return { ...parts, facts: factsOf(parts, rubs), sizes: sizesOf(parts) };
}

/** Return the conditions under which variables exist, as in `shape.py`; `rubs`: whether contacts at walls have friction. */
function factsOf({ file: { chain, inputs, outputs, stops: { model } }, pairs, sliderStops, stops, hasFriction }, rubs) {
  const hasContacts = pairs.length > 0 || sliderStops.length > 0;
  const hasLimits = chain.slider?.force_limit !== undefined || chain.links.some((link) => link.joint_torque_limit !== undefined);
  return {
    ...flags(inputs, "inputs"),
    ...flags(outputs, "outputs"),
    always: true,
    free: chain.base === "free",
    contacts: hasContacts,
    stops: stops.length > 0,
    law: hasContacts || (stops.length > 0 && !model),
    contact_friction: rubs,
    friction: hasFriction,
    supply: anyOnChain(inputs) || inputs.wall_motion.length > 0 || hasLimits,
  };
}

/** Return the counts of the record under their names, as in `counts.py`. */
function sizesOf({ file: { chain: { links, slider }, inputs, outputs }, candidates, hasFriction, wallNames, movingWalls, sites, driven }) {
  return {
    links: links.length,
    candidates: candidates.length,
    elements: hasFriction ? links.length + candidates.length + (slider ? 1 : 0) : 0,
    loads: outputs.loads ? links.length + wallNames.length : 0,
    channels: 2 * inputs.base_motion + 2 * movingWalls.length,
    sites: sites.length,
    signals: driven.length,
    knots: driven.reduce((sum, { knots }) => sum + knots, 0),
  };
}

/** Return the values of a table under their dotted keys. */
function flags(table, name) {
  return Object.fromEntries(Object.entries(table).map(([key, value]) => [`${name}.${key}`, value]));
}

/**
 * Return the owners of variables of each kind, as in `shape.py`: a number, the name of a wall, the index in the record, and
 * conditions.
 */
export function ownersOf(parts) {
  const { file, sites, sliderStops, stops, existingWalls, wallNames, pairs, candidates, rubbingJoints, movingWalls, joints } = parts;
  const { links } = parts.sizes;
  const ofJoints = (numbers) => numbers.map((n) => ({ n, at: n - 1 }));
  const { inputs, outputs, chain: { slider } } = file;
  return {
    one: [{}],
    link: range(links).map((at) => {
      const hasTarget = inputs.joint_targets && joints.includes(at + 1);
      return { n: at + 1, at, has_target: hasTarget, rests: !hasTarget, rubs: rubbingJoints.includes(at + 1) };
    }),
    point: range(links + 1 + sites.length).map((n) => ({ n, at: n })),
    joint: ofJoints(joints),
    "rubbing joint": ofJoints(rubbingJoints),
    site: sites.map(({ link, entry, corner }, at) => ({ n: entry + 1, of: link + 1, at, link, entry, corner, placed: !corner })),
    slider: slider ? [{ rests: !inputs.joint_targets, rubs: slider.friction > 0, at: links }] : [],
    line: file.walls.map(({ name }, at) => ({ name, at })),
    material: pairs.length ? existingWalls.map((name) => ({ name, at: wallNames.indexOf(name) })) : [],
    contact: [
      ...pairs.map(([n, wall], at) => ({ n, name: wallNames[wall], at })),
      ...sliderStops.map((name, k) => ({ n: 0, name, at: pairs.length + stops.length + k, contact_friction: false })),
    ],
    stop: [...new Set(stops.map(([joint]) => joint))].map((n) =>
      ({ n, at: pairs.length + candidates.slice(pairs.length).findIndex(([joint]) => joint === n) })),
    "moving wall": movingWalls.map((name, k) => ({ name, at: 2 * inputs.base_motion + 2 * k })),
    "touched wall": wallNames.flatMap((name, number) => (pairs.some(([, wall]) => wall === number) ? [{ name, at: links + number }] : [])),
    impact: range(outputs.impacts).map((at) => ({ n: at + 1, at })),
  };
}

/** Return whether inputs act on a chain in flight: inputs other than motions of walls. */
export function anyOnChain({ joint_torques: torques, joint_targets: targets, slider_force: slider, tip_force: tip, base_motion: base }) {
  return torques || targets || slider || tip || base;
}

/** Return a template with the words of an owner filled in. */
export function filled(text, { n, of, name }) {
  const before = n > 1 ? `link ${n - 1}` : "the base";
  return text.replaceAll("{n}", n).replaceAll("{of}", of).replaceAll("{name}", name).replaceAll("{before}", before);
}

/** Return the rows of templates for every owner of their kind, and whether the owner meets their conditions. */
export function rowsOfOwners(groups, owners, facts) {
  return groups.flatMap(({ of, rows }) => owners[of].flatMap((owner) => {
    const known = { ...facts, ...owner };
    return rows.map((row) => ({ ...row, of, owner, name: filled(row.name, owner), has: row.when.every((fact) => known[fact]) }));
  }));
}
