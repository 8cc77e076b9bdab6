// The address of the page, which contains the open scene, the reader's changes and the chosen outputs.

import { Changes } from "../scene/changes.js";
import { inputStepsIn } from "../scene/input_steps.js";
import { contentsIn } from "../scene/scene_file.js";
import { changesIn, hashOf } from "./export.js";

const REST = 300; // [ms] the changes are put into the address when nothing has changed for this time

export class Address {
  #timer;

  /**
   * Use the scene, the changes and the outputs in the present address, and keep the address up to date afterwards. `choice`: the chosen
   * outputs; `refuse`: function that shows a sentence on a fault in the address.
   */
  constructor(changes, choice, openScene, refuse) {
    Object.assign(this, { changes, choice, openScene, refuse });
    if (location.hash) this.#apply(location.hash);
    changes.onChange(() => this.updateSoon());
    // the address comes from the event, because `updateSoon` may have replaced the page's address since the event was made
    addEventListener("hashchange", ({ newURL }) => this.#apply(new URL(newURL).hash));
  }

  get text() {
    const hash = hashOf(this.changes, { scene: this.openScene.text, curves: this.choice.names.join() });
    return location.href.split("#")[0] + (hash && `#${hash}`);
  }

  /** Put the changes into the address when nothing has changed for a while: browsers limit how often a page may change its address. */
  updateSoon() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => history.replaceState(null, "", this.text), REST);
  }

  /**
   * Use the scene, the changes and the outputs in the part of an address from "#" on, `hash`. If the scene has a fault, show the fault, and
   * use none of the three. If the changes or the outputs have a fault, show the fault, and use only the scene.
   */
  #apply(hash) {
    const { changes, choice, openScene } = this;
    try {
      const { scene: text = "", curves = "", ...parts } = changesIn(hash);
      if (text && text !== openScene.text) openScene.open(contentsIn(text));
      else if (text !== openScene.text) openScene.openFirst();
      const { others, inputSteps } = inputStepsIn(parts, changes);
      const values = new Changes(changes.scene).with(others);
      choice.take(curves);
      changes.replace(values, inputSteps);
    } catch (error) {
      this.refuse(`The link cannot be used: ${error.message}.`);
      this.updateSoon();
    }
  }
}
