// The place of the map: on a wide screen a panel beside the motion, elsewhere, or when the reader enlarges it, a dialog over the page.

import { byId } from "../../base/dom.js";

export class MapPlace {
  #isEnlarged = false;

  constructor(dialog) {
    this.dialog = dialog;
    this.button = byId("map-enlarge");
    this.wide = matchMedia("(min-width: 1200px) and (min-height: 600px)");
    this.wide.addEventListener("change", () => dialog.open && this.show());
    this.button.addEventListener("click", () => this.#enlarge(!this.#isEnlarged));
    this.foldButton = byId("map-fold");
    this.foldButton.addEventListener("click", () => this.#fold(this.foldButton.ariaExpanded === "true"));
    // fields that are set fold, so that the map is larger; on a phone they have no room
    byId("map-run").addEventListener("click", () => setTimeout(() => this.#fold(!dialog.querySelector(":invalid"))));
    this.#fold(matchMedia("(max-width: 760px) and (min-height: 481px)").matches);
    dialog.addEventListener("cancel", (event) => {
      if (!this.#isEnlarged || !this.wide.matches) return;
      event.preventDefault();
      this.#enlarge(false);
    });
    dialog.addEventListener("close", () => {
      if (!dialog.open) this.#isEnlarged = false; // else it has only changed its place
      this.#tell();
    });
    document.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || event.defaultPrevented || !this.isBeside || document.querySelector("dialog:modal")) return;
      if (dialog.contains(event.target) || !event.target.closest("input, select")) dialog.close();
    });
  }

  /** Return whether the map is shown as a panel, with which the rest of the page can be used. */
  get isBeside() {
    return this.dialog.open && !this.dialog.matches(":modal");
  }

  /** Show the map in its place. */
  show() {
    this.dialog.close();
    if (this.wide.matches && !this.#isEnlarged) this.dialog.show();
    else this.dialog.showModal();
    this.#tell();
  }

  /** Let the motion be seen: show the map as a panel or, without room for it, close it; return whether it is closed. */
  makeRoom() {
    if (!this.wide.matches) this.dialog.close();
    else if (this.#isEnlarged) this.#enlarge(false);
    return !this.dialog.open;
  }

  #enlarge(isEnlarged) {
    this.#isEnlarged = isEnlarged;
    this.show();
    this.button.focus();
  }

  #fold(isFolded) {
    this.foldButton.ariaExpanded = !isFolded;
  }

  #tell() {
    document.body.classList.toggle("with-map", this.isBeside);
    byId("map-open").ariaExpanded = this.isBeside;
    this.button.ariaPressed = this.#isEnlarged;
  }
}
