// Gestures: changes of the scene or of parameters, such as those of a drag or of arrow keys, that the reader takes for one.

import { hashOf } from "./export.js";

const GESTURE = 800; // [ms] changes with less time between them count as one change

/**
 * Call `listener` after each change of the scene or of a parameter from now on, with whether the change begins a gesture. While one of the
 * `handles` is dragged, all changes count as one. What the reader enters in a field or chooses from a list begins a gesture.
 */
export function onGesture(changes, handles, listener) {
  const state = () => ({ hash: hashOf(changes), dragged: handles.dragged, scene: changes.scene });
  let [last, at] = [state(), -Infinity];
  document.addEventListener("change", ({ target }) => {
    if (target.type !== "range") at = -Infinity;
  }, true); // before the field makes its change
  changes.onChange(() => {
    const [present, now] = [state(), performance.now()];
    if (present.hash !== last.hash || present.scene !== last.scene) {
      const goesOn = present.dragged !== null && present.dragged === last.dragged;
      listener(!goesOn && now - at > GESTURE);
      at = now;
    }
    last = present;
  });
}
