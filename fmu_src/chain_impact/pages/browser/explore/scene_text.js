// The text of the scene in the editor: each valid text is opened at once, and a fault is told with its line and its key.

import { byId } from "../base/dom.js";
import { readable } from "../base/format.js";
import { contentsOf, tomlText } from "../scene/changed_file.js";
import { contentsIn } from "../scene/scene_file.js";
import { fileFault } from "./file_fault.js";

const PAUSE = 400; // [ms] a text is read when the reader has not typed for this time

export class SceneText {
  #timer = 0;
  #before = {}; // `text` that the page has shown last, and `state` of the open scene then

  constructor(changes, openScene, keys) {
    Object.assign(this, { changes, openScene, keys, field: byId("edit-toml") });
    this.field.addEventListener("input", () => {
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => this.#take(), PAUSE);
    });
  }

  /** Show the text of the present scene, unless the reader edits it. */
  show() {
    if (document.activeElement === this.field) return;
    this.field.value = tomlText(contentsOf(this.changes), this.keys);
    this.#before = { text: this.field.value, state: this.openScene.state };
    this.#tell("");
  }

  /** Open the scene of the text; if the text has the scene of before again, the state of before comes back. */
  #take() {
    const { openScene, changes } = this;
    const { text, state } = this.#before;
    try {
      const contents = contentsIn(this.field.value);
      if (!openScene.areSame(contents, contentsIn(text))) openScene.open(contents);
      else if (changes.scene !== state.scene) openScene.restore(state);
      this.#tell("");
    } catch (error) {
      this.#tell(`Not taken: ${fileFault(error, this.field.value)}`);
    }
  }

  #tell(fault) {
    this.field.setAttribute("aria-invalid", Boolean(fault));
    byId("edit-toml-text").textContent = readable(fault);
  }
}
