// The tables of compared motions: a summary with a row for each motion, and, on request, a table with a row for each impact.

import { make } from "../base/dom.js";
import { digits, durationText, peakText, unitsOf, withMinus } from "../base/format.js";
import { writerOf } from "../charts/chart.js";
import { partingTime } from "../recording/parting.js";
import { partnerOf } from "../recording/partners.js";
import { capitalized, placeText } from "../scene/words.js";

const TO_PRESENT = "From this motion to the present one";
const SAME_TIME = 1e-9; // [s] times that differ by less count as equal
const LEAST_FACTOR = 10; // least factor between two forces or impulses that is told as a factor, not in percent
const ENERGY_ROUND_OFF = 1e-6; // energies below this, relative to the largest one, count as 0
const LISTED_COUNT = 100; // number of impacts of each motion, from the first on, that are compared
const LEAST_DIFFERENCE = 0.01; // least relative difference of a time since the start, or of a force, that the summary tells
// the heads of the columns of the summary, with tooltips
const HEADS = [
  ["impacts"],
  ["largest", "Largest force of an impact or, without forces, largest impulse"],
  ["end energy", "Total energy at the end"],
  ["motions differ from", "Time from which on a point is elsewhere by 1\u202f% of the size of the motion; marked ▾ in the charts"],
  ["first other impact", `First impact whose time since the start, or force, differs by more than ${100 * LEAST_DIFFERENCE}\u202f%`],
  ["order differs from", "First impact that is at another point or wall than the impact with the same number"],
];

/**
 * Return the parts of the summary of `motions`, the present one first: each motion has a `recording`, a `title` (an element) and, if it is
 * pinned, a `letter`. All changes are from the motion with the index `reference`. The head of the table begins with the `button`. If
 * `isPresent` is false, the motion of the present values is unknown, and dashes replace the changes from it and to it.
 */
export function summaryTable(motions, { reference, button, isPresent }) {
  const { recording: from } = motions[reference];
  const direction = make("small", { textContent: `changes from ${shortName(motions[reference])}` });
  const heads = HEADS.map(([textContent, title = ""]) => make("th", { scope: "col", textContent, title }));
  const head = make("tr", {}, make("th", { scope: "col" }, button, direction), ...heads);
  const written = writerOf(motions.flatMap(({ recording: { energies } }) => Object.values(energies)));
  const body = motions.map(({ title, recording }, k) => {
    const told = [String(recording.impacts.length), largestText(recording), energyText(endEnergy(recording), written)];
    const isKnown = isPresent || (k > 0 && reference > 0);
    const changes = [countChange(from, recording), changeText(recording, from), energyChange(from, recording, written)];
    const titleText = `From ${shortName(motions[reference])} to ${shortName(motions[k])}`;
    const changeOf = (text) => (k === reference ? "" : isKnown ? text : "–");
    const cells = told.map((text, n) => make("td", {}, text, make("small", { textContent: changeOf(changes[n]), title: titleText })));
    if (k === reference) cells.push(make("td", { colSpan: 3, className: "reference", textContent: "reference" }));
    else cells.push(...differencesOf(motions[reference], motions[k], isKnown));
    cells.forEach((cell, n) => cell.className || cell.setAttribute("data-head", HEADS[n][0])); // on a phone, it stands above its number
    return make("tr", {}, title, ...cells);
  });
  return [make("thead", {}, head), make("tbody", {}, ...body)];
}

/** Return the letter of a pinned motion, or "present" for the present one. */
function shortName({ letter = "present" }) {
  return letter;
}

/**
 * Return the parts of a table with a row for each impact, and a column for each of some `motions` (as for `summaryTable`, with the element
 * `name` in place of the title): the impacts that belong together are in one row (`alignedImpacts`).
 */
export function pairsTable(motions, isPresent) {
  const rows = alignedImpacts(motions.map(({ recording }) => recording));
  const heads = ["#", "impact", ...motions.map(({ name }) => name)];
  const head = make("tr", {}, ...heads.map((part) => make("th", { scope: "col" }, part)));
  const body = rows.map((row) => {
    const number = make("td", { textContent: row[0]?.number ?? "" });
    return make("tr", {}, number, make("th", { scope: "row", textContent: placeText(row.find(Boolean)) }), ...motions.map((_, k) =>
      cellOf(row[k], k > 0 && isPresent ? row[0] : null, row.doubtful[k], row[0]?.number)));
  });
  if (motions.some(({ recording: { impacts } }) => impacts.length > LISTED_COUNT)) {
    const textContent = `the first ${LISTED_COUNT} of each motion are listed`;
    body.push(make("tr", {}, make("td"), make("td", { colSpan: 1 + motions.length, textContent })));
  }
  return [make("thead", {}, head), make("tbody", {}, ...body)];
}

/** Return the total energy of a recording at its end [J], 0 if it is round-off (ENERGY_ROUND_OFF); undefined if there are no energies. */
function endEnergy({ energies: { total, ...parts } }) {
  const largest = Object.values(parts).flatMap((values) => Array.from(values)).reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  const end = total?.at(-1);
  return Math.abs(end) < ENERGY_ROUND_OFF * largest ? 0 : end;
}

/** Return an energy [J] as text; `written` is a function that writes values with as many decimals as the energies of the motions need. */
function energyText(joules, written) {
  return joules === undefined ? "–" : `${joules === 0 ? "0" : written(joules)}\u202fJ`;
}

/** Return the change of the energy at the end from one recording to another as text; "" if an energy is unknown. */
function energyChange(from, to, written) {
  const change = endEnergy(to) - endEnergy(from);
  if (Number.isNaN(change)) return "";
  const text = written(change);
  return /[1-9]/.test(text) ? `${change > 0 ? "+" : ""}${text}\u202fJ` : "0";
}

/** Return the change of the number of impacts from one recording to another as text. */
function countChange({ impacts: { length: from } }, { impacts: { length: to } }) {
  return from === to ? "0" : `${to > from ? "+" : "−"}${Math.abs(to - from)}`;
}

/**
 * Return {text, title, change} for the first impact that differs clearly (LEAST_DIFFERENCE) between the motion `reference` and another
 * one, or that only one of them has: words, a tooltip, and the result of `changeWords`. Without one, the text is "none".
 */
function firstDifference(reference, other) {
  const [from, to] = [reference.recording, other.recording];
  const isClear = ([now, then]) => {
    if (!now || !then) return true;
    const [gap, since] = [now.onset - then.onset, Math.min(now.onset - to.start, then.onset - from.start)];
    const key = forceKeyOf(now, then);
    const isForceClear = key !== "" && Math.abs(now[key] - then[key]) > LEAST_DIFFERENCE * then[key];
    return Math.abs(gap) > LEAST_DIFFERENCE * since + SAME_TIME || isForceClear;
  };
  const row = alignedImpacts([to, from]).find(isClear);
  if (!row) return { text: "none" };
  const [now, then] = row;
  const { number, onset } = now ?? then;
  const title = capitalized(placeText(now ?? then));
  if (now && then) return { text: `impact ${number}`, title, change: changeWords(then, now) };
  return { text: `impact ${number} (${onset.toFixed(4)}\u202fs): only in ${shortName(now ? other : reference)}`, title };
}

/** Return the result of `differenceOf` in words, such as "+2 ms, force −3 %". An equal time is left out. */
function changeWords(impact, present) {
  const [time, ratio] = differenceOf(impact, present);
  const ofPeak = present.atStop ? "moment" : "force";
  const word = forceKeyOf(impact, present) === "peak_force" ? ofPeak : "impulse";
  return [/[1-9]/.test(time) && time, ratio && `${word} ${ratio}`].filter(Boolean).join(", ");
}

/** Return three cells of the table, which tell where a motion begins to differ from the motion `reference`; dashes unless `isKnown`. */
function differencesOf(reference, other, isKnown) {
  if (!isKnown) return Array.from({ length: 3 }, () => make("td", { textContent: "–" }));
  const parting = partingTime(reference.recording, other.recording);
  const text = parting === undefined ? "never" : `${parting.toFixed(4)}\u202fs`;
  const first = firstDifference(reference, other);
  const change = make("small", { textContent: first.change ?? "" });
  const order = orderOf(reference, other);
  return [[{ text }], [first, change], [order]].map(([one, ...more]) => make("td", { title: one.title ?? "" }, one.text, ...more));
}

/** Return {text, title} for the first impact at which point and wall differ between two motions, in the order of their impacts. */
function orderOf(...motions) {
  const [from, to] = motions.map(({ recording: { impacts } }) => impacts.slice(0, LISTED_COUNT));
  const k = Array.from({ length: Math.max(from.length, to.length) }).findIndex((_, n) =>
    !from[n] || !to[n] || placeText(from[n]) !== placeText(to[n]));
  if (k < 0) return { text: "none" };
  const told = motions.map((motion, n) => `${shortName(motion)}: ${[from, to][n][k] ? placeText([from, to][n][k]) : "no such impact"}`);
  return { text: `impact ${k + 1}, ${(to[k] ?? from[k]).onset.toFixed(4)}\u202fs`, title: told.join("; ") };
}

/**
 * Return rows of impacts that belong together, sorted by the onset of the first impact in each row. A row has one entry for each recording
 * of `all`: an impact or undefined. Each of the first LISTED_COUNT impacts of a recording is in one row, with its partners in others;
 * `doubtful` of a row tells for each entry whether it is a doubtful partner.
 */
function alignedImpacts(all) {
  const used = new Set();
  const newIn = ({ impacts }) => impacts.slice(0, LISTED_COUNT).filter((impact) => !used.has(impact));
  const rows = all.flatMap((recording, k) => newIn(recording).map((first) => {
    const pairs = all.map((other, n) => (n === k ? { partner: first } : partnerOf(first, recording, other)));
    const row = pairs.map(({ partner }) => (used.has(partner) ? undefined : partner));
    row.doubtful = pairs.map(({ isDoubtful }) => isDoubtful);
    row.forEach((impact) => used.add(impact));
    return row;
  }));
  const onsetOf = (row) => row.find(Boolean).onset;
  return rows.toSorted((one, other) => onsetOf(one) - onsetOf(other));
}

/**
 * Return { value, unit, text }: the largest peak force of a recording or, if no peak force or moment is known, the largest impulse, of
 * ended contacts if there are any. At stops of joints, peak moments and impulses of moments replace forces and impulses; they count only if
 * no other impact has a known value of this kind. The result is null if no value is known.
 */
function largestKnown({ impacts }) {
  const [peaks, impulses] = ["peak_force", "impulse"].map((key) => impacts.filter((impact) => Number.isFinite(impact[key] ?? NaN)));
  // without a rest, whose impulse grows with time
  const ended = impulses.filter((impact) => Number.isFinite(impact.separation_speed ?? NaN));
  const known = [peaks, ended, impulses].find(({ length }) => length) ?? [];
  const atWalls = known.filter(({ atStop }) => !atStop);
  const key = peaks.length ? "peak_force" : "impulse";
  const impact = (atWalls.length ? atWalls : known).reduce((one, other) => (one && one[key] >= other[key] ? one : other), null);
  if (!impact) return null;
  return { value: impact[key], unit: unitsOf(impact)[key], text: peakText(impact) };
}

/** Return a text: the largest peak force of a recording; the largest impulse if no peak force is known; a dash if neither is known. */
export function largestText(recording) {
  return largestKnown(recording)?.text ?? "–";
}

/** Return the values of `largestKnown` for two recordings; an empty list if the units of the values differ, or a value is unknown. */
function comparableOf(...recordings) {
  const [one, other] = recordings.map(largestKnown);
  return one && one.unit === other?.unit ? [one.value, other.value] : [];
}

/**
 * Return the change of the largest force (or else impulse) from `other` to a recording as text: in percent of the value of `other`, as in
 * "−12 %", or as a factor from LEAST_FACTOR on, as in "× 1350"; "" if the units differ, a value is unknown, or the value of `other` is 0.
 */
function changeText(recording, other) {
  return ratioText(...comparableOf(recording, other));
}

/** Return the change from a value `base` to `value` as text, as `changeText` does. */
function ratioText(value, base) {
  if (!(base > 0)) return "";
  if (value >= LEAST_FACTOR * base) return `×\u202f${Number((value / base).toPrecision(3))}`;
  const percent = 100 * (value / base - 1);
  const rounded = Math.abs(percent) < 0.05 ? "0" : digits(percent, 2);
  return `${percent > 0 && rounded !== "0" ? "+" : ""}${withMinus(rounded)}\u202f%`;
}

/** Return words for the number of impacts, and their largest force (or else impulse), before and after a change; "" without a change. */
export function differenceText(before, present) {
  if (!before || before === present) return "";
  const [counts, largest] = [({ impacts }) => impacts.length, largestText].map((of) => [before, present].map(of));
  const told = comparableOf(before, present).length ? [counts, largest] : [counts];
  if (told.flat().length > 2 && told.every(([old, now]) => old === now)) return "same number, same largest";
  return told.map((pair) => pair.join(" → ")).join(", largest ");
}

/**
 * Return a table's cell for an impact: onset, and peak force or impulse, with a tooltip that tells the duration; a dash without impact. The
 * cell also tells the impact's own number, if it differs from the `number` of the column's impact of the present motion, and the changes of
 * time and force to its partner `present` in this motion, if this is known. The cell of a doubtful partner is grey.
 */
function cellOf(impact, present, isDoubtful, number) {
  if (!impact) return make("td", { textContent: "–", title: "No impact of this point and wall is near" });
  const force = peakText(impact, "rigid");
  const until = `until ${durationText(impact.end - impact.onset)} later`;
  const title = `Impact ${impact.number}: ${placeText(impact)}, ${until}${isDoubtful ? "; perhaps another impact" : ""}`;
  const cell = make("td", { title, className: isDoubtful ? "doubtful" : "" });
  if (impact.number !== number) cell.append(make("small", { className: "own-number", textContent: `#${impact.number}` }), " ");
  cell.append(`${impact.onset.toFixed(4)}\u202fs`, make("small", { textContent: force }));
  const change = present && `→ now ${differenceOf(impact, present).filter(Boolean).join(", ")}`;
  if (present) cell.append(make("small", { textContent: change, title: `${title}. ${TO_PRESENT}` }));
  return cell;
}

/** Return the quantity that compares two impacts: "peak_force" or, if both have no peak force, "impulse"; "" if only one has none. */
function forceKeyOf(one, other) {
  const hasNone = [one, other].filter(({ peak_force }) => peak_force === null).length;
  return ["peak_force", "", "impulse"][hasNone];
}

/** Return the changes of time and of peak force (or impulse, if no peak is known) from an impact to its partner `present` as texts. */
function differenceOf(impact, present) {
  const time = present.onset - impact.onset;
  const gap = Math.abs(time) < SAME_TIME ? `0\u202fs` : (time > 0 ? "+" : "") + withMinus(durationText(time));
  const key = forceKeyOf(impact, present);
  return [gap, key && ratioText(present[key], impact[key])];
}
