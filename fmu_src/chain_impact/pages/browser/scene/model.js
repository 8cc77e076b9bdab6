// The model of a scene for the page: its variables and its record, from the contents of its file and the templates of
// `kit.py`.

import { NORMALS, pointText, STOPS, sumOf, wallsAt } from "./geometry.js";
import { movablePoints, sitesOf, sliderStopsOf, stopsOf, wallsOf } from "./scene_file.js";
import { checkDriven, drivenBy, drivenPlaces, putSignals, signalElements } from "./signals.js";

const BYTES = 8; // [bytes] size of a word
// the largest cosine between a slider's line and a wall's normal that counts as 0, because of round-off
const PARALLEL = 1e-12;

/** Return the numbers from 0 to length − 1. */
const range = (length) => Array.from({ length }, (_, k) => k);

/** Return the place of a word in a record of these sizes: a constant, and a slope for each size and for the index. */
function placeOf([constant, ...slopes], sizes, index = 0) {
  return [...sizes, index].reduce((sum, size, k) => sum + slopes[k] * size, constant);
}

/** Return all such places, in nested tables. */
function placesOf(words, sizes) {
  if (Array.isArray(words)) return placeOf(words, sizes);
  return Object.fromEntries(Object.entries(words).map(([name, inner]) => [name, placesOf(inner, sizes)]));
}

/** Return whether a point slides along a line parallel to a wall, so that it never reaches the wall. */
function keepsDistance({ chain: { slider, links }, walls }, sites, point, name) {
  const site = sites[point - links.length - 1];
  const isAtBase = point === 0 || (site && site.link === 0 && site.x === 0 && site.y === 0);
  if (!slider || !isAtBase) return false;
  const angle = walls.find((wall) => wall.name === name)?.angle;
  const [nx, ny] = NORMALS[name] ?? [-Math.sin(angle), Math.cos(angle)];
  return Math.abs(nx * Math.cos(slider.angle) + ny * Math.sin(slider.angle)) < PARALLEL;
}

/** Return the parts of a scene on which its variables and its record depend. */
function partsOf(file, { boxWalls, signals }) {
  const { chain: { base, links, slider }, walls, contact, inputs, outputs } = file;
  const count = links.length;
  const [points, stops, there] = [contact.points ?? movablePoints(file), stopsOf(file), wallsOf(file)];
  const [sites, sliderStops] = [sitesOf(file), sliderStopsOf(file)];
  const movable = sites.flatMap(({ link, x, y }, s) => (base === "pinned" && link === 0 && x === 0 && y === 0 ? [] : [count + 1 + s]));
  const touching = [...points, ...movable];
  const reaches = (point, name) => !keepsDistance(file, sites, point, name);
  const mayTouch = there.length > 0 && (slider || sites.length > 0)
    ? touching.some((point) => there.some((name) => reaches(point, name))) : touching.length > 0;
  const wallNames = [...boxWalls, ...(mayTouch ? walls.map(({ name }) => name) : []), ...(stops.length ? STOPS : []), ...sliderStops];
  const numbers = wallNames.flatMap((name, number) => (there.includes(name) ? [number] : []));
  const pairs = touching.flatMap((point) => numbers.map((wall) => [point, wall])).filter(([point, wall]) => reaches(point, wallNames[wall]));
  const materials = Object.values(contact.wall);
  const rubs = mayTouch && there.length > 0 && (contact.friction > 0 || contact.static_friction > 0 ||
    materials.some(({ friction, static_friction: least }) => friction !== undefined || least !== undefined));
  const firstJoint = base === "free" ? 2 : 1;
  const joints = range(count).map((k) => k + 1).filter((joint) => joint >= firstJoint);
  const rubbing = joints.filter((joint) => links[joint - 1].joint_friction > 0);
  const moving = wallNames.filter((name) => there.includes(name) && inputs.wall_motion.some((one) => one === "*" || one === name));
  const candidates = [
    ...pairs,
    ...stops.map(([joint, stop]) => [joint, wallNames.indexOf(stop)]),
    ...sliderStops.map((stop) => [0, wallNames.indexOf(stop)]),
  ];
  const driven = drivenBy(file, signals);
  const hasFriction = rubs || rubbing.length > 0 || slider?.friction > 0;
  const isDriven = anyOnChain(inputs) || inputs.wall_motion.length > 0 || slider?.force_limit !== undefined || links.some((link) => link.joint_torque_limit !== undefined);
  const facts = {
    ...flags(inputs, "inputs"),
    ...flags(outputs, "outputs"),
    always: true,
    free: base === "free",
    contacts: pairs.length > 0 || sliderStops.length > 0,
    stops: stops.length > 0,
    law: pairs.length > 0 || sliderStops.length > 0 || (stops.length > 0 && !file.stops.model),
    contact_friction: rubs,
    friction: hasFriction,
    driven: isDriven,
  }; // in the order of `shape.py`
  const sizes = [
    count,
    candidates.length,
    hasFriction ? count + candidates.length + (slider ? 1 : 0) : 0,
    outputs.loads ? count + wallNames.length : 0,
    2 * inputs.base_motion + 2 * moving.length,
    sites.length,
    driven.length,
    driven.reduce((sum, { knots }) => sum + knots, 0),
  ];

  return { file, driven, points, sites, mayTouch, sliderStops, stops, there, wallNames, pairs, candidates, rubbing, hasFriction, moving, joints, facts, sizes };
}

/** Return the values of a table under their dotted keys. */
function flags(table, name) {
  return Object.fromEntries(Object.entries(table).map(([key, value]) => [`${name}.${key}`, value]));
}

/**
 * Return the elements of each kind, as in `shape.py`: a number, the name of a wall, the index in the record, and conditions.
 */
function elementsOf({ file, sites, sliderStops, stops, there, wallNames, pairs, candidates, rubbing, moving, joints, sizes: [links] }) {
  const ofJoints = (wanted) => wanted.map((n) => ({ n, at: n - 1 }));
  const { inputs, outputs, chain: { slider } } = file;
  return {
    one: [{}],
    link: range(links).map((at) => {
      const follows = inputs.joint_targets && joints.includes(at + 1);
      return { n: at + 1, at, follows, rests: !follows, rubs: rubbing.includes(at + 1) };
    }),
    point: range(links + 1 + sites.length).map((n) => ({ n, at: n })),
    joint: ofJoints(joints),
    "rubbing joint": ofJoints(rubbing),
    site: sites.map(({ link, entry, corner }, at) => ({ n: entry + 1, of: link + 1, at, link, entry, corner, placed: !corner })),
    slider: slider ? [{ rests: !inputs.joint_targets, rubs: slider.friction > 0, at: links }] : [],
    line: file.walls.map(({ name }, at) => ({ name, at })),
    material: pairs.length ? there.map((name) => ({ name, at: wallNames.indexOf(name) })) : [],
    contact: [
      ...pairs.map(([n, wall], at) => ({ n, name: wallNames[wall], at })),
      ...sliderStops.map((name, k) => ({ n: 0, name, at: pairs.length + stops.length + k, contact_friction: false })),
    ],
    stop: [...new Set(stops.map(([joint]) => joint))].map((n) =>
      ({ n, at: pairs.length + candidates.slice(pairs.length).findIndex(([joint]) => joint === n) })),
    "moving wall": moving.map((name, k) => ({ name, at: 2 * inputs.base_motion + 2 * k })),
    "touched wall": wallNames.flatMap((name, number) => (pairs.some(([, wall]) => wall === number) ? [{ name, at: links + number }] : [])),
    impact: range(outputs.impacts).map((at) => ({ n: at + 1, at })),
  };
}

/** Return where the record has an input, as `acting` of `driving.py`: the number of its kind, and its index. */
function actingOf({ acts: [number, index], element: { at } }) {
  return [number, { "{at}": at, "{next}": at + 1 }[index] ?? index];
}

/** Return a template with the words of an element filled in. */
function filled(text, { n, of, name }) {
  return text.replaceAll("{n}", n).replaceAll("{of}", of).replaceAll("{name}", name).replaceAll("{before}", n > 1 ? `link ${n - 1}` : "the base");
}

/** Return the rows of templates for every element of their kind, and whether the element meets their conditions. */
function instances(groups, elements, facts) {
  return groups.flatMap(({ of, rows }) => elements[of].flatMap((element) => {
    const known = { ...facts, ...element };
    return rows.map((row) => ({ ...row, of, element, name: filled(row.name, element), has: row.when.every((fact) => known[fact]) }));
  }));
}

/** Return the values of everything that may be a parameter: name → number, and whether the number is derived. */
function valuesOf(file, rows) {
  const [values, derived] = [new Map(), []];
  for (const { name, path, element, rule, items, has } of rows) {
    const indices = { "{at}": element.at, "{name}": element.name, "{link}": element.link, "{entry}": element.entry };
    const steps = path.map((step) => indices[step] ?? step);
    const given = steps.reduce((table, step) => table?.[step], file);
    const number = items.length && given !== undefined ? items.findIndex(([id]) => id === given) + 1 : given;
    if (number !== undefined) values.set(name, { number, steps });
    else if (rule && (has || element.corner)) {
      const own = (rule.ofBox && file.chain.links[element.at]?.height && rule.ofBox) || rule;
      derived.push({ name, steps, rule: { ...own, terms: own.terms.map((term) => term.map((factor) => filled(factor, element))) } });
    }
  }
  for (const { name, steps, rule } of derived) {
    values.set(name, { number: sumOf(rule, (factor) => values.get(factor).number), steps, derived: rule });
  }
  return values;
}

/** Return whether inputs act on a chain in flight: inputs other than motions of walls. */
function anyOnChain({ joint_torques: torques, joint_targets: targets, slider_force: slider, tip_force: tip, base_motion: base }) {
  return torques || targets || slider || tip || base;
}

/** Return the record of the scene, not initialized; `asked` are the scene's inputs by name, with or without a signal. */
function recordOf(kit, parts, rows, values, asked) {
  const { file, sizes, candidates, pairs, sites, sliderStops, stops, hasFriction, moving, wallNames, mayTouch, facts } = parts;
  const { inputs, outputs, chain } = file;
  const bytes = new Uint8Array(placeOf(kit.size, sizes) * BYTES);
  const [reals, integers] = [new Float64Array(bytes.buffer), new BigInt64Array(bytes.buffer)];
  const write = (words, value, isReal, index = 0) => {
    const place = placeOf(words, sizes, index);
    if (isReal) reals[place] = value;
    else integers[place] = BigInt(value);
  };
  const put = (name, value, index = 0) => write(kit.places[name].word, value, kit.places[name].real, index);
  const each = (name, all) => all.forEach((value, index) => put(name, value, index));
  kit.sizes.forEach((name, k) => put(name, sizes[k]));
  put("skewed", Number(chain.links.some(({ center_of_mass_offset: offset }) => offset !== 0)));
  put("slides", Number(chain.slider !== undefined));
  each("site_link", sites.map(({ link }) => link));
  each("site_corner", sites.map(({ corner = 0 }) => corner));
  put("regularized", kit.constants.noContact);
  each("candidate_point", candidates.map(([point]) => point));
  each("candidate_wall", candidates.map(([, wall]) => wall));
  stops.forEach(([, stop], k) => put("candidate_stop", stop === STOPS[0] ? 1 : -1, pairs.length + k));
  sliderStops.forEach((stop, k) => put("candidate_stop", stop === "slider_min" ? 2 : -2, pairs.length + stops.length + k));
  put("pinned", Number(chain.base !== "free"));
  put("driven", Number(anyOnChain(inputs)));
  put("followed", Number(inputs.joint_targets));
  put("base_moves", Number(inputs.base_motion));
  put("follows", 1);
  const first = 2 * inputs.base_motion;
  moving.forEach((_, k) => put("belt", 1, first + 2 * k + 1));
  each("channel", candidates.map(([, wall]) => (moving.includes(wallNames[wall]) ? first + 2 * moving.indexOf(wallNames[wall]) : -1)));
  putSignals(parts.driven, kit.signals, (input) => actingOf(asked.get(input)), put);
  put("kept", outputs.impacts);
  put("impulses", Number(outputs.contacts || outputs.impacts > 0 || outputs.loads || (hasFriction && outputs.energies)));
  ["wall_restitution", "wall_friction", "wall_static_friction"].forEach((name) =>
    each(name, range(kit.boxWalls.length + sizes[1]).map(() => -1)));
  const laws = kit.laws.map(({ name }) => name);
  put("stop_law", laws.indexOf(file.stops.model) + 1);
  for (const { name, of, word, given, givenIf, type, element, missing } of rows) {
    const value = values.get(name) ?? (of === "link" || of === "slider" ? { number: Number(missing) } : null);
    if (!value || (of === "line" && !mayTouch)) continue;
    write(word, value.number, type === "real", element.at);
    if (given && facts[givenIf]) write(given, value.derived ? kit.constants.derived : value.number, true, element.at);
  }
  return bytes;
}

/** Return the words of the record that the page draws; null for values that the scene does not have. */
function drawnOf(kit, { sizes, pairs, sliderStops, wallNames, joints }, columns) {
  const words = new Map(columns.map(({ name, word }) => [name, word]));
  const word = (name) => words.get(name) ?? null;
  const touch = (point, wall, values) => ({ point, wall, sign: 1, force: null, depth: null, friction: null, sticking: null, ...values });
  const atWalls = pairs.map(([point, wall]) => {
    const of = `contact[${point}].${wallNames[wall]}`;
    const [force, depth] = [word(`${of}.force`), word(`${of}.penetration`)];
    return touch(point, wallNames[wall], { force, depth, friction: word(`${of}.friction_force`), sticking: word(`${of}.sticking`) });
  });
  const onSlider = [
    ...sliderStops.map((stop) => touch(0, stop, { force: word(`contact[0].${stop}.force`), depth: word(`contact[0].${stop}.penetration`) })),
    touch(0, "", { friction: word("slider.friction_force"), sticking: word("slider.sticking") }),
  ];
  const inJoints = joints.flatMap((joint) => {
    const of = `joint[${joint}]`;
    const stops = STOPS.map((stop, k) => touch(joint, stop, { sign: k ? -1 : 1, force: word(`${of}.stop_moment`) }));
    return [...stops, touch(joint, "", { friction: word(`${of}.friction_moment`), sticking: word(`${of}.sticking`) })];
  });
  return {
    points: range(sizes[0] + 1 + sizes[5]).map((k) => kit.points.map((place) => placeOf(place, sizes, k))),
    energies: Object.fromEntries([...words].flatMap(([name, at]) => (name.startsWith("energy.") ? [[name.slice(7), at]] : []))),
    touches: [...atWalls, ...onSlider, ...inJoints].filter(({ force, sticking }) => force !== null || sticking !== null),
    loads: joints
      .map((joint) => ({ joint, x: word(`joint[${joint}].force.x`), y: word(`joint[${joint}].force.y`) }))
      .filter(({ x }) => x !== null),
  };
}

/** Return the model of a scene; `command` are the words after `chain-impact simulate` that repeat a run. */
export function describe(kit, file, command) {
  const parts = partsOf(file, kit);
  const { sizes, stops, wallNames, there, facts } = parts;
  const pointNames = parts.sites.flatMap(({ name }, s) => (name ? [[sizes[0] + 1 + s, name]] : []));
  const elements = elementsOf(parts);
  const all = (groups) => instances(groups, elements, facts).filter(({ has }) => has);
  const [moving, settable] = [all(kit.still), all(kit.inputs)];
  const asked = new Map([...settable, ...moving].map((row) => [row.name, row]));
  const units = new Map([...asked].map(([name, { unit }]) => [name, unit]));
  checkDriven(parts.driven, units);
  const places = drivenPlaces(parts.driven);
  const isFree = ({ name }) => !places.has(name);
  const rows = instances(kit.parameters, { ...elements, ...signalElements(parts.driven, units) }, facts);
  const values = valuesOf(file, rows);
  const record = recordOf(kit, parts, rows, values, asked);
  const reals = new Float64Array(record.buffer);
  const shown = rows.filter(({ name, has, trivial }) => has && values.has(name) && values.get(name).number !== trivial);
  const names = new Set(shown.map(({ name }) => name));
  const inputs = settable
    .filter(isFree)
    .map((row) => ({ ...row, number: reals[placeOf(row.word, sizes, row.element.at)] }));
  const parameter = ({ name, element, given, givenIf, word, rule, number, of, path, has, when, trivial, missing, ...row }) => {
    const { steps = null, derived, number: start = number } = values.get(name) ?? {};
    const follows = derived?.terms.flat().every((factor) => names.has(factor)) ? derived : null;
    const place = word ? placeOf(given && facts[givenIf] ? given : word, sizes, element.at) : -1;
    // numbers of a signal have the unit of the driven input
    const unit = row.unit === "1" ? element.unit ?? row.unit : row.unit;
    return { ...row, name, unit, place: steps, word: place, text: filled(row.text, element), start, derived: follows };
  };
  const times = kit.times.map((row) => ({ ...row, element: {} }));
  valuesOf(file, times).forEach((value, name) => values.set(name, value));
  const driven = [...asked.values()].filter((row) => !isFree(row)).map(({ name, unit }) => {
    const [row, order] = places.get(name);
    return { name, unit, word: placeOf(kit.driven[order], sizes, row), integer: false };
  });
  const columns = [...driven, ...all(kit.outputs)
    .map(({ name, unit, word, integer, element }) => ({ name, unit, word: placeOf(word, sizes, element.at), integer }))];
  const named = new Set(parts.driven.map(({ input }) => input));
  return {
    name: file.name,
    file,
    text: file.description,
    command,
    links: sizes[0],
    pinned: file.chain.base === "pinned",
    wallNames,
    walls: wallsAt({ walls: Object.fromEntries(there.map((name) => [name, null])) }, (name) => values.get(name)?.number),
    stops: [...new Set(stops.map(([joint]) => joint))],
    openArc: kit.constants.openArc,
    atOnce: kit.constants.atOnce,
    sites: parts.sites,
    sliderStops: parts.sliderStops,
    pointNames,
    contactPoints: [...new Set(parts.pairs.map(([point]) => point))],
    record,
    layout: placesOf(kit.layout, sizes),
    inputs: inputs.map(({ name }) => name),
    still: moving.filter(isFree).map(({ name }) => name),
    forms: kit.signals.other,
    driven: driven.filter(({ name }) => named.has(name)),
    moved: driven.filter(({ name }) => /^wall\..*\.displacement$/.test(name)),
    parameters: [...shown, ...inputs, ...times].map(parameter),
    columns,
    drawn: drawnOf(kit, parts, columns),
    rigidWithFriction: kit.rigidWithFriction,
    statuses: kit.statuses,
    places: [ // the words for the reasons of a refusal: each candidate, each link, and the base at each wall
      ...parts.pairs.map(([point, wall]) => `${pointText(new Map(pointNames), point)} at the wall ${wallNames[wall]}`),
      ...stops.map(([joint, stop]) => `joint ${joint} at its ${stop}`),
      ...parts.sliderStops.map((stop) => `the slider at its ${stop}`),
      ...file.chain.links.map((_, k) => `link[${k + 1}]`),
      ...parts.pairs.map(([, wall]) => `the base at the wall ${wallNames[wall]}`),
    ],
  };
}
