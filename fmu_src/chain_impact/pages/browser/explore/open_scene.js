// The open scene: the page's own scene, or a scene from a file, from the address or from an edit.

import { byId } from "../base/dom.js";
import { tomlText } from "../scene/changed_file.js";
import { pageScene } from "../scene/page_scene.js";
import { asWritten, completedFile } from "../scene/scene_file.js";
import { inputText, sceneText } from "../scene/words.js";
import { editedScene } from "./edited_scene.js";


export class OpenScene {
  text = ""; // the text of the open scene's file; "" for the page's own scene

  constructor(changes, choice, kit) {
    const origin = { scene: changes.scene, text: "" }; // the open scene before its edits
    Object.assign(this, { changes, choice, kit, first: origin, origin });
    changes.onChange(() => this.#describe());
    this.#describe();
  }

  /** Show the scene with which the page was made. */
  openFirst() {
    this.origin = this.first;
    this.undoEdits();
  }

  /** Show the open scene as it was opened, without later edits. */
  undoEdits() {
    this.#show(this.origin.scene, this.origin.text);
  }

  /** Return the open scene with the reader's changes and chosen outputs, which `restore` shows again. */
  get state() {
    const { origin, text, choice: { names }, changes: { scene, values, inputSteps } } = this;
    return { origin, text, names, scene, values, inputSteps };
  }

  /** Show a state again; if its scene is the present one, the choice of outputs stays. */
  restore({ origin, text, names, scene, ...kept }) {
    this.origin = origin;
    if (scene === this.changes.scene) {
      this.changes.replace(kept.values, kept.inputSteps);
    } else {
      this.choice.names = names;
      this.#show(scene, text, kept);
    }
  }

  get isEdited() {
    return this.changes.scene !== this.origin.scene;
  }

  /** Open the scene of a file's contents, without changes; if the contents have a fault, the error names the wrong key. */
  open(contents) {
    this.origin = this.#sceneWithText(this.#sceneIn(contents));
    this.undoEdits();
  }

  /**
   * Open the edited contents of the present scene, and keep the reader's changes and chosen outputs. If the contents have a fault, the
   * error names the wrong key. `before`: the result of `partsOf` before the edit. Return words for the signals and inputs that the edit
   * removes.
   */
  openEdited(contents, before) {
    const { changes, choice, kit } = this;
    const { nameOf, kept, removed, ...edited } = editedScene(contents, before, changes, { kit, open: (file) => this.#sceneIn(file) });
    choice.names = choice.names.map(nameOf).filter(Boolean);
    const { scene, text } = this.#sceneWithText(edited);
    this.#show(scene, text, kept);
    return removed;
  }

  /** Return the complete file for some contents, and its scene; in commands the file's name is the scene's name with the suffix .toml. */
  #sceneIn(contents) {
    const whole = completedFile(contents, this.kit);
    return { whole, scene: pageScene(this.kit, whole, [`${whole.name}.toml`]) };
  }

  /** Return a scene with the text of its file; if an edit is taken back, the scene before the edits, or the page's own scene. */
  #sceneWithText({ whole, scene }) {
    const text = this.#textOf(whole);
    return [this.origin, this.first].find((known) => this.#textOf(known.scene.file) === text) ?? { scene, text };
  }

  #textOf(whole) {
    return tomlText(asWritten(whole), this.kit.keys);
  }

  /** Return whether two contents of scene files give the same scene; an error names the wrong key. */
  areSame(contents, others) {
    return this.#textOf(completedFile(contents, this.kit)) === this.#textOf(completedFile(others, this.kit));
  }

  /** Show a scene, with the text of its file and the changes `kept` in it. */
  #show(scene, text, kept) {
    this.text = text;
    this.changes.open(scene, kept);
  }

  /** Show name and description of the open scene, and notes on its inputs. */
  #describe() {
    const { scene: { name, text, inputs, driven, still }, starts, valueOf } = this.changes;
    Object.assign(document.querySelector("h1"), { textContent: sceneText(name), title: name });
    document.title = `${sceneText(name)} – chain-impact`;
    const isFree = inputs.length > 0 && driven.length === 0 && inputs.every((input) => starts[input] === 0);
    byId("description").textContent = [text, isFree && "Here no controller sets the inputs."].filter(Boolean).join(". ");
    byId("description").hidden = !byId("description").textContent;
    byId("inputs").hidden = still.length === 0;
    const words = still.map((input) => inputText(input, valueOf)).join("; ");
    byId("inputs").textContent = `These inputs keep their start values here: ${words}. A signal in the scene file can change them.`;
    byId("edit-first").hidden = !this.text;
  }
}
