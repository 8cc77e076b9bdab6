// The record of a scene, from which the kernel begins: its size, the indices of its words, and its contents.

import { anyOnChain, range } from "./owners.js";
import { BOX_WALLS } from "./geometry.js";
import { putSignals } from "./signals.js";

/** Return the index of a word in a record of these sizes: a constant, and a slope for each count and for the index. */
export function wordIndex([constant, ...slopes], sizes, index = 0) {
  const counts = SHARED.record.COUNTS.map((name) => sizes[name]);
  return [...counts, index].reduce((sum, count, k) => sum + slopes[k] * count, constant);
}

/** Return the indices of all words of nested tables in a record of these sizes. */
export function wordIndices(words, sizes) {
  if (Array.isArray(words)) return wordIndex(words, sizes);
  return Object.fromEntries(Object.entries(words).map(([name, inner]) => [name, wordIndices(inner, sizes)]));
}

/** Return where the record has an input, as `acting` of `driving.py`: the number of its kind, and its index. */
function actingOf({ acts: [number, index], owner: { at } }) {
  return [number, { "{at}": at, "{next}": at + 1 }[index] ?? index];
}

/** Return the record of the scene, not initialized; `byName` are the scene's inputs, with or without a signal. */
export function recordOf(kit, parts, rows, values, byName) {
  const { file, sizes, candidates, pairs, sites, sliderStops, stops, hasFriction, movingWalls, wallNames, mayTouch, facts } = parts;
  const { inputs, outputs, chain } = file;
  const bytes = new Uint8Array(wordIndex(kit.size, sizes) * SHARED.record.WORD);
  const [reals, integers] = [new Float64Array(bytes.buffer), new BigInt64Array(bytes.buffer)];
  const write = (words, value, isReal, index = 0) => {
    const at = wordIndex(words, sizes, index);
    if (!(at in reals)) throw new RangeError(`word ${at} is outside the record, which has ${reals.length} words`);
    if (isReal) reals[at] = value;
    else integers[at] = BigInt(value);
  };
  const put = (name, value, index = 0) => write(kit.fields[name].word, value, kit.fields[name].real, index);
  const each = (name, all) => all.forEach((value, index) => put(name, value, index));
  SHARED.record.COUNTS.forEach((name) => put(name, sizes[name]));
  put("skewed", Number(chain.links.some(({ center_of_mass_offset: offset }) => offset !== 0)));
  put("slides", Number(chain.slider !== undefined));
  each("site_link", sites.map(({ link }) => link));
  each("site_corner", sites.map(({ corner = 0 }) => corner));
  put("regularized", SHARED.kernel.NO_CONTACT);
  each("candidate_point", candidates.map(([point]) => point));
  each("candidate_wall", candidates.map(([, wall]) => wall));
  const allStops = [...stops.map(([, stop]) => stop), ...sliderStops];
  allStops.forEach((stop, k) => put("candidate_stop", SHARED.kernel.STOP_CODES[stop], pairs.length + k));
  put("has_base_joint", Number(chain.base !== "free"));
  put("has_inputs", Number(anyOnChain(inputs)));
  put("has_servos", Number(inputs.joint_targets));
  put("base_moves", Number(inputs.base_motion));
  put("interpolates", 1);
  const first = 2 * inputs.base_motion;
  movingWalls.forEach((_, k) => put("belt", 1, first + 2 * k + 1));
  const channelOf = (name) => (movingWalls.includes(name) ? first + 2 * movingWalls.indexOf(name) : -1);
  each("channel", candidates.map(([, wall]) => channelOf(wallNames[wall])));
  putSignals(parts.driven, kit.tables, (input) => actingOf(byName.get(input)), put);
  put("kept", outputs.impacts);
  put("impulses", Number(outputs.contacts || outputs.impacts > 0 || outputs.loads || (hasFriction && outputs.energies)));
  ["wall_restitution", "wall_friction", "wall_static_friction"].forEach((name) =>
    each(name, range(BOX_WALLS.length + sizes.candidates).map(() => -1)));
  put("stop_law", kit.laws.indexOf(file.stops.model) + 1);
  for (const { name, of, word, given, givenIf, type, owner, missing } of rows) {
    const value = values.get(name) ?? (of === "link" || of === "slider" ? { number: Number(missing) } : null);
    if (!value || (of === "line" && !mayTouch)) continue;
    if (of === "line" && owner.at >= candidates.length) throw new RangeError(`walls: the record has room for ${candidates.length}`);
    write(word, value.number, type === "real", owner.at);
    if (given && facts[givenIf]) write(given, value.derived ? SHARED.kernel.DERIVED : value.number, true, owner.at);
  }
  return bytes;
}
