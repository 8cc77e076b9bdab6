// The known name that is most similar to an unknown one.
// The twin in Python is `scene/texts/similar_names.py`.

const { LIKE_LAST, LIKE_NAME, NUMBER, SAME_LAST, SYNONYMS } = SHARED.nearest;
const INDICES = new RegExp(NUMBER, "g");
const lastOf = (name) => name.slice(name.lastIndexOf(".") + 1);

/**
 * Return the number of letters that two texts have in common: those of their longest common part, and, found in the same way, those that
 * the texts have in common before this part and after it.
 */
function commonLetters(a, b) {
  let [size, atA, atB] = [0, 0, 0];
  for (let i = 0; i < a.length; i += 1) {
    for (let j = 0; j < b.length; j += 1) {
      let k = 0;
      while (i + k < a.length && j + k < b.length && a[i + k] === b[j + k]) k += 1;
      if (k > size) [size, atA, atB] = [k, i, j];
    }
  }
  return size && size + commonLetters(a.slice(0, atA), b.slice(0, atB)) + commonLetters(a.slice(atA + size), b.slice(atB + size));
}

/**
 * Return the name that is most similar to `name`; of equally similar names, the one that is last in the alphabet. The result is undefined
 * if no name has at least the similarity `least`.
 */
function mostAlike(name, names, least) {
  const likeness = (other) => 2 * commonLetters([...other], [...name]) / ([...other].length + [...name].length);
  const rated = names.map((other) => [likeness(other), other]).filter(([rate]) => rate >= least);
  return rated.reduce((best, one) => (one[0] > best[0] || (one[0] === best[0] && one[1] > best[1]) ? one : best), [-1])[1];
}

/** Return, from the list `names`, the name that the reader most likely meant with the unknown `name`; undefined if none is similar. */
function nearest(name, names) {
  const last = lastOf(name);
  const owner = name.slice(0, -last.length);
  const meant = `${owner}${Object.hasOwn(SYNONYMS, last) ? SYNONYMS[last] : last}`;
  if (meant !== name && names.includes(meant)) return meant;
  const bare = name.replaceAll(INDICES, "");
  const numbersOf = (text) => [...text.matchAll(INDICES)].map(([found]) => Number(found.slice(1, -1)));
  const numbered = names.filter((other) => other !== name && other.replaceAll(INDICES, "") === bare);
  if (numbered.length) {
    const own = numbersOf(name);
    const distance = (other) => numbersOf(other).reduce((sum, number, k) => sum + Math.abs(number - own[k]), 0);
    const alike = numbered.filter((other) => numbersOf(other).length === own.length);
    return alike.length ? alike.reduce((best, other) => (distance(other) < distance(best) ? other : best)) : numbered[0];
  }
  const own = names.filter((other) => owner && other.startsWith(owner)).map((other) => other.slice(owner.length));
  const owned = longer(last, own);
  if (owned) return `${owner}${owned}`;
  if (last === name) {
    const rank = (other) => (other.startsWith("contact.") ? 0 : 1);
    const first = names.toSorted((a, b) => rank(a) - rank(b) || a.length - b.length);
    const alike = mostAlike(name, [...new Set(first.map(lastOf))], LIKE_LAST);
    if (alike !== undefined) return first.find((other) => lastOf(other) === alike);
  }
  const same = last !== name && last.length > 1 ? names.filter((other) => lastOf(other) === last) : [];
  const found = mostAlike(name, names, LIKE_NAME);
  return same.includes(found) ? found : mostAlike(name, same, SAME_LAST) ?? found;
}

/** Return, from the list `names`, the shortest one that contains `text` as whole words; undefined if none does, or for an empty text. */
function longer(text, names) {
  const words = new RegExp(`(?<![\\p{L}\\p{N}])${text.replaceAll(/[\\^$.*+?()[\]{}|]/g, "\\$&")}(?![\\p{L}\\p{N}])`, "u");
  return names.filter((name) => text && words.test(name)).toSorted((a, b) => a.length - b.length)[0];
}

/** Return the end of a message on an unknown name: "; the nearest is …", or "" if none of `names` is similar. */
export function nearestText(name, names) {
  const near = proposed(name, names);
  return near === undefined ? "" : `; the nearest is ${near}`;
}

/** Return, from the list `names`, the one that a message proposes for an unknown name; undefined without a proposal. */
export function proposed(name, names) {
  return nearest(name, names) ?? longer(name, names);
}
