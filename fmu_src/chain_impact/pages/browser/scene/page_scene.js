// The model of a scene for the page: its variables and its record, made from the contents of the scene's file and the templates of
// `scene_tables.py`.

import { mapValues } from "../base/map_values.js";
import { valueInFile } from "../base/paths.js";
import { range } from "../base/range.js";
import { pointText, sumOf, wallsAt } from "./geometry.js";
import { filledTemplate, rowsOfOwners, structureOf } from "./owners.js";
import { recordOf, wordIndex, wordIndices } from "./record.js";
import { drivenRows, withOutputs } from "./signals.js";

/**
 * Return the values in a file for `rows` of variables: name → the `number`, its path in the file (`steps`) and, for a number that follows
 * from others, the rule (`derived`).
 */
function valuesOf(file, rows) {
  const [values, derived] = [new Map(), []];
  for (const { name, path, owner, rule, items, has, valueIfNotInFile = null } of rows) {
    const indices = { "{at}": owner.at, "{name}": owner.name, "{link}": owner.link, "{entry}": owner.entry };
    const steps = path.map((step) => indices[step] ?? step);
    const given = valueInFile(file, steps);
    const number = items.length && given !== undefined ? items.findIndex(([id]) => id === given) + 1 : given;
    if (number !== undefined) values.set(name, { number, steps });
    else if (has && valueIfNotInFile !== null) values.set(name, { number: valueIfNotInFile, steps });
    else if (rule && (has || owner.corner)) {
      const ownRule = (rule.ofBox && file.chain.links[owner.at]?.height && rule.ofBox) || rule;
      const terms = ownRule.terms.map((term) => term.map((factor) => filledTemplate(factor, owner)));
      derived.push({ name, steps, rule: { ...ownRule, terms } });
    }
  }
  for (const { name, steps, rule } of derived) {
    values.set(name, { number: sumOf(rule, (factor) => values.get(factor).number), steps, derived: rule });
  }
  return values;
}

/**
 * Return the indices in the record of what the page draws: `points`, the coordinates of each point, and `groups`, the quantities of
 * `drawn_outputs.py` by group and owner.
 */
function drawnOf(kit, sceneNumbers, outputs) {
  const groups = Object.fromEntries(SHARED.drawn.GROUPS.map((group) => [group, new Map()]));
  for (const { drawn, owner: { n = 0, name = "" }, word } of outputs.filter((row) => row.drawn)) {
    const [entries, key] = [groups[drawn[0]], `${n}.${name}`];
    if (!entries.has(key)) entries.set(key, { n, name, words: {} });
    entries.get(key).words[drawn[1]] = word;
  }
  return {
    points: range(sceneNumbers.link_count + 1 + sceneNumbers.site_count).map((k) =>
      kit.points.map((coordinate) => wordIndex(coordinate, sceneNumbers, k))),
    groups: mapValues(groups, (entries) => [...entries.values()]),
  };
}

/**
 * Return the parameters of a scene in the form of the page: those of `rows` that the scene has, then `others`: inputs, stop time and
 * communication step.
 */
function parametersOf(rows, others, values, { sceneNumbers }, byName) {
  const shown = rows.filter(({ name, has }) => has && values.has(name));
  const names = new Set(shown.map(({ name }) => name));
  return [...shown, ...others].map((parameter) => {
    const { name, owner, givenWord, givenWordWhen, word, rule, number, ...other } = parameter;
    const { ownerKind, path, has, when, valueIfNotInFile, numberForNone, ...row } = other;
    const { steps = null, derived, number: start = number } = values.get(name) ?? {};
    const follows = derived?.terms.flat().every((factor) => names.has(factor)) ? derived : null;
    const index = word ? wordIndex(givenWord && sceneNumbers[givenWordWhen] ? givenWord : word, sceneNumbers, owner.at) : -1;
    // in a row for signals the unit "1" stands for the unit of the input that the signal drives
    const unit = row.unit === "1" && owner.input ? byName.get(owner.input).unit : row.unit;
    return { ...row, name, unit, filePath: steps, word: index, text: filledTemplate(row.text, owner), start, derived: follows };
  });
}

/** Return words for each part of a scene that can be the reason for a fault, in the order of `part_texts` in candidates.py. */
function partsInWords({ file, pairs, stops, sliderStops, wallNames }, pointNames) {
  return [
    ...pairs.map(([point, wall]) => `${pointText(pointNames, point)} at the wall ${wallNames[wall]}`),
    ...stops.map(([joint, stop]) => `joint ${joint} at its ${stop}`),
    ...sliderStops.map((stop) => `the slider at its ${stop}`),
    ...file.chain.links.map((_, k) => `link[${k + 1}]`),
    ...file.chain.links.map((_, k) => `joint ${k + 1}`),
    ...(file.chain.base === "slider" ? ["the slider"] : []),
    ...pairs.map(([, wall]) => `the base at the wall ${wallNames[wall]}`),
  ];
}

/** Return the variables and the record of a scene; `command`: the words after `chain-impact simulate` in the command that repeats a run. */
export function pageScene(kit, file, command) {
  const structure = structureOf(file, kit);
  const { stops, wallNames, existingWalls, sceneNumbers, sites } = structure;
  const pointNames = sites.flatMap(({ name }, s) => (name ? [[sceneNumbers.link_count + 1 + s, name]] : []));
  const all = (groups) => rowsOfOwners(groups, structure).filter(({ has }) => has);
  const [motions, settable] = [all(kit.motions), all(kit.inputs)];
  const filledAll = (row, key) => row[key].map((name) => filledTemplate(name, row.owner));
  const byName = new Map([...settable, ...motions].map((row) =>
    [row.name, { ...row, family: filledAll(row, "family"), alone: filledAll(row, "alone") }]));
  const drivenInputs = withOutputs(structure.driven, byName, file.signals);
  const driving = drivenRows(drivenInputs);
  const isFree = ({ name }) => !driving.has(name);
  const rows = rowsOfOwners(kit.parameters, structure);
  const values = valuesOf(file, rows);
  const record = recordOf(kit, structure, drivenInputs, rows, values, byName);
  const reals = new Float64Array(record.buffer);
  const inputs = settable
    .filter(isFree)
    .map((row) => ({ ...row, number: reals[wordIndex(row.word, sceneNumbers, row.owner.at)] }));
  const times = kit.times.map((row) => ({ ...row, owner: {} }));
  valuesOf(file, times).forEach((value, name) => values.set(name, value));
  const driven = [...byName.values()].filter((row) => !isFree(row)).map(({ name, unit, owner }) => {
    const [row, order] = driving.get(name);
    return { name, unit, word: wordIndex(kit.driven[order], sceneNumbers, row), integer: false, ownerName: owner.name };
  });
  const outputs = all(kit.outputs).map((row) => ({ ...row, word: wordIndex(row.word, sceneNumbers, row.owner.at) }));
  const columns = [...driven, ...outputs.map(({ name, unit, text, word, integer, isPeakLoad }) =>
    ({ name, unit, text, word, integer, isPeakLoad }))];
  const named = new Set(structure.driven.map(({ input }) => input));
  return {
    name: file.name,
    file,
    text: file.description,
    command,
    links: sceneNumbers.link_count,
    pinned: file.chain.base === "pinned",
    wallNames,
    walls: wallsAt({ walls: Object.fromEntries(existingWalls.map((name) => [name, null])) }, (name) => values.get(name)?.number),
    stops: [...new Set(stops.map(([joint]) => joint))],
    sites,
    sliderStops: structure.sliderStops,
    pointNames,
    pairs: structure.pairs.map(([point, wall]) => [point, wallNames[wall]]),
    contactPoints: [...new Set(structure.pairs.map(([point]) => point))],
    record,
    layout: wordIndices(kit.layout, sceneNumbers),
    inputs: inputs.map(({ name }) => name),
    still: motions.filter(isFree).map(({ name }) => name),
    driven: driven.filter(({ name }) => named.has(name)),
    moved: driven.filter(({ name }) => byName.get(name).displaces),
    parameters: parametersOf(rows, [...inputs, ...times], values, structure, byName),
    columns,
    drawn: drawnOf(kit, sceneNumbers, outputs),
    partsInWords: partsInWords(structure, new Map(pointNames)),
  };
}
