// The record of a scene, with which a run of the kernel begins: its size, the indices of its words (8 bytes each), and its contents.
// The twins in Python are `variables/filling.py`, `variables/signal_filling.py`.

import { valuesOfScene } from "./owners.js";
import { numberIn, valuesOfMembers } from "./rules.js";
import { putSignals } from "./signals.js";

/**
 * Return the index of a word in a record: a constant, plus a multiple of each count in `sizes`, plus a multiple of the `index` of the
 * owner.
 */
export function wordIndex([constant, ...slopes], sizes, index = 0) {
  const counts = SHARED.record.COUNTS.map((name) => sizes[name]);
  return [...counts, index].reduce((sum, count, k) => sum + slopes[k] * count, constant);
}

/** Return the nested tables `words`, with each word replaced by its index in a record that has the counts `sizes`. */
export function wordIndices(words, sizes) {
  if (Array.isArray(words)) return wordIndex(words, sizes);
  return Object.fromEntries(Object.entries(words).map(([name, inner]) => [name, wordIndices(inner, sizes)]));
}

/** Return the number of an input's kind and the index of the input among its kind, as `input_at` of `signal_filling.py`. */
function actingOf({ acts: [number, index], owner: { at } }) {
  return [number, { "{at}": at, "{next}": at + 1 }[index] ?? index];
}

/**
 * Return the record of the scene, before its initialization. `driven`: the driven inputs with all quantities that they determine; `byName`:
 * all inputs, driven or not.
 */
export function recordOf(kit, structure, driven, rows, values, byName) {
  const { file, sceneNumbers, lists } = structure;
  const bytes = new Uint8Array(wordIndex(kit.size, sceneNumbers) * SHARED.record.WORD);
  const [reals, integers] = [new Float64Array(bytes.buffer), new BigInt64Array(bytes.buffer)];
  const write = (words, value, isReal, index = 0) => {
    const at = wordIndex(words, sceneNumbers, index);
    if (!(at in reals)) throw new RangeError(`word ${at} is outside the record, which has ${reals.length} words`);
    if (isReal) reals[at] = value;
    else integers[at] = BigInt(value);
  };
  const put = (name, value, index = 0) => write(kit.fields[name].word, value, kit.fields[name].real, index);
  const valueOf = valuesOfScene(file, lists, sceneNumbers);
  for (const [name, { number, sourceList, at }] of Object.entries(kit.recordNumbers)) {
    valuesOfMembers(sourceList, valueOf).forEach((ofMember) => put(name, numberIn(number, ofMember), numberIn(at, ofMember)));
  }
  putSignals(driven, kit.tables, (input) => actingOf(byName.get(input)), put);
  for (const { name, ownerKind, word, givenWord, givenWordWhen, type, owner, numberForNone } of rows) {
    const value = values.get(name) ?? (numberForNone === null ? null : { number: Number(numberForNone) });
    if (!value) continue;
    if (ownerKind === "sloped wall" && owner.at >= sceneNumbers.candidate_count) {
      throw new RangeError(`walls: the record has room for ${sceneNumbers.candidate_count}`);
    }
    write(word, value.number, type === "real", owner.at);
    if (givenWord && sceneNumbers[givenWordWhen]) write(givenWord, value.derived ? SHARED.kernel.NOT_GIVEN : value.number, true, owner.at);
  }
  return bytes;
}
