// The structure of a scene: its facts and lists, and the conditions, counts and owners of variables that follow from them by the tables of
// `facts.py` and `owners.py`.
// The twins in Python are `scene/facts.py`, `variables/owners.py`, `variables/structure.py`.

import { mapValues } from "../base/map_values.js";
import { valueInFile } from "../base/paths.js";
import { BOX_WALLS, STOPS } from "./geometry.js";
import { isRuleTrue, membersIn, numberIn, valuesOfMembers } from "./rules.js";
import { pairsOf, sitesOf, sliderStopsOf, stopsOf, touchingPoints, wallsOf } from "./scene_file.js";
import { drivenBy } from "./signals.js";

/** Return the structure of a scene, as `structure.py` does, and the parts of the scene that decide the structure. */
export function structureOf(file, kit) {
  const [stops, existingWalls, sites, sliderStops, reached] = [stopsOf, wallsOf, sitesOf, sliderStopsOf, pairsOf].map((of) => of(file));
  const mayTouch = (existingWalls.length > 0 ? reached : touchingPoints(file)).length > 0;
  const slopedWalls = mayTouch ? file.walls.map(({ name }) => name) : [];
  const wallNames = [...BOX_WALLS, ...slopedWalls, ...(stops.length ? STOPS : []), ...sliderStops];
  const pairs = reached.map(([point, name]) => [point, wallNames.indexOf(name)]);
  const parts = { file, driven: drivenBy(file, kit.tables), sites, sliderStops, stops, existingWalls, slopedWalls, wallNames, pairs };
  const lists = listsOf(parts, kit);
  const sceneNumbers = numbersOfScene(file, lists, kit);
  return { ...parts, lists, sceneNumbers, owners: mapValues(kit.owners, (row) => ownersIn(row, sceneNumbers, lists)) };
}

/** Return a function from a name in the rules of `owners.py` to its value, as the function `values_of` in `owners.py` does. */
export function valuesOfScene(file, lists, sceneNumbers) {
  return (name) => (name.includes(".") ? valueInFile(file, name.split(".")) : lists[name] ?? sceneNumbers[name]);
}

/** Return name of a list of a scene → its members, each a table of values, as `LISTS` in `facts.py` describes them. */
function listsOf({ file, driven, sites, sliderStops, stops, existingWalls, slopedWalls, wallNames, pairs }, kit) {
  const { STOP_CODES } = SHARED.kernel;
  const lists = {
    sites: sites.map(({ link, entry, corner = 0, name }) => ({ link, entry, corner, label: name })),
    candidates: [
      ...pairs.map(([n, wall]) => ({ n, wall, name: wallNames[wall], stop: 0, at_joint: false })),
      ...stops.map(([n, stop]) => ({ n, wall: wallNames.indexOf(stop), stop: STOP_CODES[stop], at_joint: true })),
      ...sliderStops.map((name) => ({ n: 0, wall: wallNames.indexOf(name), name, stop: STOP_CODES[name], at_joint: false })),
    ],
    walls: wallNames.map((name, number) =>
      ({ name, exists: existingWalls.includes(name), touched: pairs.some(([, wall]) => wall === number) })),
    sloped_walls: slopedWalls.map((name) => ({ name })),
    laws: kit.laws.map((name) => ({ name })),
    signals: driven.map(({ name, input, knots }) => ({ name, input, knots })),
    steps: driven.filter(({ signal }) => signal.form === "steps").flatMap(({ name, input, signal, first }) =>
      signal.times.map((_, entry) => ({ name, input, entry, knot: first + entry }))),
  };
  const valueOf = valuesOfScene(file, lists, {});
  for (const [name, { sourceList, condition, values }] of Object.entries(kit.lists)) {
    lists[name] = valuesOfMembers(sourceList, valueOf).flatMap((ofMember) => {
      const own = {};
      if (!isRuleTrue(condition, ofMember)) return [];
      for (const [key, rule] of Object.entries(values)) own[key] = numberIn(rule, (inner) => own[inner] ?? ofMember(inner));
      return [own];
    });
  }
  return lists;
}

/** Return the values of a table by their dotted keys; a list counts as its length. */
function flags(table, name) {
  return Object.fromEntries(Object.entries(table).map(([key, value]) => [`${name}.${key}`, value.length ?? value]));
}

/** Return name → number for the keys of [inputs] and [outputs], the facts, the counts and the lengths of lists (owners.py). */
function numbersOfScene(file, lists, { facts, counts }) {
  const sceneNumbers = { ...flags(file.inputs, "inputs"), ...flags(file.outputs, "outputs") };
  const valueOf = valuesOfScene(file, lists, sceneNumbers);
  for (const [name, rule] of Object.entries(facts)) sceneNumbers[name] = numberIn(rule, valueOf);
  return { ...sceneNumbers, ...mapValues(lists, ({ length }) => length), ...mapValues(counts, (rule) => numberIn(rule, valueOf)) };
}

/**
 * Return the owners that one row of the table of owners finds: the members of its list for which `condition` is true, each with its
 * numbers and conditions. If several of them have the same `n`, `of` and name, only the first is an owner.
 */
function ownersIn({ sourceList, condition, numbers, conditions }, sceneNumbers, lists) {
  const found = new Map();
  membersIn(sourceList, (name) => lists[name] ?? sceneNumbers[name]).forEach((member, order) => {
    const here = { ...sceneNumbers, ...member, order };
    const valueOf = (name) => here[name];
    if (!isRuleTrue(condition, valueOf)) return;
    const owner = { ...member, ...mapValues(numbers, (rule) => numberIn(rule, valueOf)) };
    for (const [name, rule] of Object.entries(conditions)) owner[name] = here[name] = isRuleTrue(rule, valueOf);
    const key = [owner.n, owner.of, owner.name].join();
    if (!found.has(key)) found.set(key, owner);
  });
  return [...found.values()];
}

/**
 * Return a template with an owner's words in place of words in braces.
 *
 * The words are the owner's number {n}, the number {of} of its link, its {name}, and {before}: the link n − 1, or the base if n is 1.
 */
export function filledTemplate(text, { n, of, name }) {
  const before = n > 1 ? `link ${n - 1}` : "the base";
  return text.replaceAll("{n}", n).replaceAll("{of}", of).replaceAll("{name}", name).replaceAll("{before}", before);
}

/** Return each row of each group once for each owner of the group's kind; `has` tells whether the owner meets the row's conditions. */
export function rowsOfOwners(groups, { owners, sceneNumbers }) {
  return groups.flatMap(({ ownerKind, rows }) => owners[ownerKind].flatMap((owner) => {
    const here = { ...sceneNumbers, ...owner };
    return rows.map((row) =>
      ({ ...row, ownerKind, owner, name: filledTemplate(row.name, owner), has: row.when.every((condition) => here[condition]) }));
  }));
}
