// Refuses contents of a scene file with the sentences and rules of `refusals.py`, which Python uses, too.

import { valueInFile, pathText } from "../base/paths.js";
import { isRuleTrue, numberIn } from "./rules.js";

/** Return a value as text for an error, as in Python's errors, cut if it is long; some values differ (1 for 1.0, true for True). */
export function shown(value) {
  const text = written(value);
  return text.length > SHARED.file.SHOWN ? `${text.slice(0, SHARED.file.SHOWN)}...` : text;
}

function written(value) {
  if (typeof value === "string") return value.includes("'") && !value.includes('"') ? `"${value}"` : `'${value.replaceAll("'", "\\'")}'`;
  if (Array.isArray(value)) return `[${value.map(written).join(", ")}]`;
  if (typeof value !== "object" || value === null) return String(value);
  return `{${Object.entries(value).map(([key, inner]) => `${written(key)}: ${written(inner)}`).join(", ")}}`;
}

/** Throw the error for the value at a `path` of the file: the sentence of a fault, with `words` in place of words in braces. */
export function refuse(path, fault, words = {}) {
  const sentence = SHARED.refusals[fault].replace(/\{(\w+)\}/g, (_, word) => {
    if (words[word] === undefined) throw new Error(`${fault}: no word for ${word}`);
    return words[word];
  });
  throw Object.assign(new RangeError(`${path || "scene"} ${sentence}`), { path });
}

/**
 * Refuse a value by the first of the rules whose condition is true. `valueOf` returns the value of a key or fact, `nameOf` the name of a
 * key for the error; `words` are further words of the sentence.
 */
export function keepRules(rules, valueOf, nameOf, words = {}) {
  const rule = rules.find(({ condition }) => isRuleTrue(condition, valueOf));
  if (!rule) return;
  const { fault, key = "", least, bound } = rule;
  const bounds = least && { least: Number(numberIn(least, valueOf).toPrecision(15)), bound };
  refuse(nameOf(key), fault, { ...words, value: shown(valueOf(key)), ...bounds });
}

/**
 * Refuse the first value of a scene file that a rule forbids together with the file's other values. `valueAt` returns the value at a path
 * of the file; `textAt` returns the name of a path, which the refusal begins with.
 */
export function keepFileRules(file, options = {}) {
  const { textAt = pathText, rules = SHARED.refusalRules.FILE, valueAt = (path) => valueInFile(file, path) } = options;
  const whole = (key) => valueAt(key.split("."));
  const tablesOf = (list, members) => members.map((_, order) => {
    const path = [...list, order];
    return [path, (key) => (key === "order" ? order : valueAt([...path, key]) ?? whole(key))];
  });
  const tables = {
    "": [[[], whole]],
    link: tablesOf(["chain", "links"], file.chain.links),
    wall: tablesOf(["walls"], file.walls),
    law: tablesOfLaws(file, valueAt),
  };
  for (const rule of rules) {
    for (const [path, valueOf] of tables[rule.of ?? ""]) {
      const words = rule.of === "law" ? { law: valueOf("law.id") } : {};
      keepRules([rule], valueOf, (key) => textAt([...path, ...key.split(".").filter(Boolean)]), words);
    }
  }
}

/** Refuse the first entry of a list of a scene file that a rule of ENTRY_REFUSALS in refusals.py forbids; `facts`: those of the scene. */
export function keepEntryRules({ chain: { base, links }, contact: { points = [] }, walls }, facts, textAt) {
  const entries = (values, pathOf) => values.map((entry, k) => ({ path: pathOf(k), known: { entry, before: values.slice(0, k) } }));
  const lists = {
    "contact.points": entries(points, () => ["contact", "points"]),
    "walls.name": entries(walls.map(({ name }) => name), (k) => ["walls", k, "name"]),
    "chain.links.points.name": links.flatMap((link, i) =>
      entries(link.points.map(({ name }) => name), () => ["chain", "links", i, "points"])),
  };
  const words = { base, first: facts.movable[0], last: facts.movable.at(-1) };
  for (const { fault, condition, of } of SHARED.refusalRules.ENTRY) {
    const wrong = lists[of].find(({ known }) => isRuleTrue(condition, (name) => known[name] ?? facts[name]));
    if (!wrong) continue;
    const { path, known: { entry, before } } = wrong;
    refuse(textAt(path), fault, { ...words, value: shown(entry), others: [...facts.reserved, ...before].join(", ") });
  }
}

/** Return for each table of a contact law its path, and a function from a key to the table's value, or to a property of its law (law.…). */
function tablesOfLaws({ chain, contact, stops }, valueAt) {
  const hasStops = chain.links.some(({ joint_min: least, joint_max: most }) => least !== undefined || most !== undefined);
  const table = (path, law, otherwise) => [path, (key) =>
    (key.startsWith("law.") ? SHARED.laws[law]?.[key.slice(4)] : valueAt([...path, key]) ?? otherwise(key, path))];
  // by default, a wall with its own sliding friction has the static friction 0, which stands for the value of the sliding friction; any
  // other wall has both values of [contact]
  const ofWall = (key, path) => {
    if (!key.endsWith("friction")) return undefined;
    return valueAt([...path, "friction"]) === undefined ? valueAt(["contact", key]) : 0;
  };
  const ofStops = (key) => (key.endsWith("friction") ? undefined : valueAt(["contact", key]));
  return [
    table(["contact"], contact.model, () => undefined),
    ...Object.keys(contact.wall).map((name) => table(["contact", "wall", name], contact.model, ofWall)),
    ...(hasStops ? [table(["stops"], stops.model ?? contact.model, ofStops)] : []),
  ];
}

/**
 * Throw the error for a `path` whose last key, or whose value, should be the name of one of `walls`, but is not; the caller has found this.
 * If the value should be the name, `value` has the first words of the sentence, such as "= 'roof' ".
 */
export function refuseWall(path, walls, value = "") {
  if (!walls.length) refuse(path, "no_walls");
  refuse(path, "no_wall", { value, walls: walls.join(", ") });
}
