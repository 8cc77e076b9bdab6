// Undo and redo: the states of the scene and its parameters, one for each gesture of the reader.

import { byId } from "../base/dom.js";
import { onGesture } from "./gestures.js";

export class UndoHistory {
  #past = []; // the states before the present one, the oldest first
  #future = []; // the states that the reader has undone, the latest undone last
  #isStep = false; // whether a change is a step to a state of this history
  #isBegin = true; // whether the next change begins a state, because the present one is the first one, or was undone or redone
  #typed = null; // the field with typed text that is not taken yet: keys for undo are left to this field

  /**
   * Listen from now on to changes of the open scene and its parameters, to the keys for undo and redo, and to their buttons. `onStep` is
   * called after a step of undo or redo.
   */
  constructor(changes, openScene, handles, onStep) {
    Object.assign(this, { openScene, onStep });
    this.present = openScene.state;
    onGesture(changes, handles, (isBegin) => this.#record(isBegin));
    byId("undo").addEventListener("click", () => this.#step(this.#past, this.#future));
    byId("redo").addEventListener("click", () => this.#step(this.#future, this.#past));
    document.addEventListener("input", ({ target }) => {
      this.#typed = target.matches("input:not([type=range], [type=checkbox])") ? target : null;
    });
    document.addEventListener("change", () => {
      this.#typed = null;
    });
    document.addEventListener("keydown", (event) => this.#press(event));
  }

  /** Let the present state have the outputs that the reader has chosen, which is no change of the scene. */
  keepOutputs() {
    this.present = this.openScene.state;
  }

  /**
   * Keep the state before a change that begins a gesture, or that is the first after undo or redo; any other change replaces the present
   * state. All these changes remove the undone states. A change that is itself a step of undo or redo keeps and removes nothing.
   */
  #record(isBegin) {
    if (!this.#isStep) {
      if (isBegin || this.#isBegin) this.#past.push(this.present);
      this.#future = [];
      this.#isBegin = false;
    }
    this.present = this.openScene.state;
    this.#show();
  }

  /** Show the last of the states `from`, and put the present one at the end of the states `to`. */
  #step(from, to) {
    const state = from.pop();
    if (!state) return;
    to.push(this.present);
    [this.#isStep, this.#isBegin] = [true, true];
    this.openScene.restore(state);
    this.#isStep = false;
    this.present = state;
    this.#show();
    this.onStep();
  }

  #show() {
    byId("undo").hidden = !this.#past.length && !this.#future.length;
    byId("redo").hidden = byId("undo").hidden;
    byId("undo").disabled = !this.#past.length;
    byId("redo").disabled = !this.#future.length;
  }

  #press(event) {
    const { key, ctrlKey, metaKey, altKey, shiftKey, target } = event;
    const isElsewhere = target.closest("dialog:not(#edit), input[type=search], textarea") || target === this.#typed;
    if (key.toLowerCase() !== "z" || !(ctrlKey || metaKey) || altKey || isElsewhere) return;
    event.preventDefault();
    if (shiftKey) this.#step(this.#future, this.#past);
    else this.#step(this.#past, this.#future);
  }
}
