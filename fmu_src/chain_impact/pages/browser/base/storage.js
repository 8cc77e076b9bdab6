// What this browser keeps of the reader's choices; where it lets the page store nothing, a choice holds until the page closes.

const PREFIX = "chain-impact-";

/** Return the text that is stored with a key, null without one. */
export function stored(key) {
  try {
    return localStorage.getItem(PREFIX + key);
  } catch {
    return null;
  }
}

export function store(key, text) {
  try {
    localStorage.setItem(PREFIX + key, text);
  } catch {
    // without storage, the choice holds until the page closes
  }
}
