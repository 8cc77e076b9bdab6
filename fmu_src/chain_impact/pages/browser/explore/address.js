// The address of the page: the open scene, the reader's changes, the chosen outputs, the pins, the time of a pause, and the switches.

import { byId } from "../base/dom.js";
import { numberText } from "../base/format.js";
import { Changes } from "../scene/changes.js";
import { inputStepsIn } from "../scene/input_steps.js";
import { contentsIn } from "../scene/scene_file.js";
import { changesIn, hashOf } from "./export.js";
import { savedState } from "./saved_page.js";

const REST = 300; // [ms] the changes are put into the address when nothing has changed for this time

// signs in an address: BETWEEN_PINS separates pins, AFTER_LETTER a pin's letter from its changes, BEFORE_NAME its letter from its name
const [BETWEEN_PINS, AFTER_LETTER, BEFORE_NAME] = ["!", "~", ":"];

// the switches of the page by their ids, besides the speed: those that differ from a new page are in the address
const SWITCHES = ["force-loop", "zoom-impact", "at-contact", "slow", "trace", "loop"];
const isOn = (id) => byId(id).matches(":checked, [aria-pressed=true]");

/** Return the ids of the switches of a new page that are on, and its speed. */
const usualSwitches = () => ({ on: SWITCHES.filter(isOn), speed: byId("speed").value });

export class Address {
  #usual = usualSwitches();
  #isRunning = false; // whether the pins of the last address are being simulated
  #timer;
  #awaited = {}; // pins and time of the last address, until `takeAwaited` returns them

  /**
   * Use the scene, the changes and the outputs in the present address, and keep the address up to date afterwards.
   *
   * @param choice the chosen outputs. @param clock the clock of the player. @param comparedMotions the compared motions; the address has
   * those that are pinned. @param refuse function that shows a sentence on a fault in the address.
   */
  constructor(changes, choice, { openScene, clock, comparedMotions, refuse }) {
    Object.assign(this, { changes, choice, openScene, clock, comparedMotions, refuse });
    const hash = location.hash || savedState().hash;
    if (hash) this.#apply(hash);
    changes.onChange(() => this.updateSoon());
    changes.onOpen(() => {
      [this.#awaited, this.#isRunning] = [{}, false]; // pins and time of an address are of its own scene
    });
    comparedMotions.onPin = () => {
      if (this.#isRunning) [this.#awaited, this.#isRunning] = [{}, false];
      this.updateSoon();
    };
    SWITCHES.forEach((id) => byId(id).addEventListener("click", () => this.updateSoon()));
    let isPlaying = clock.playing;
    clock.onChange(() => {
      if (!clock.playing || !isPlaying) this.updateSoon();
      isPlaying = clock.playing;
    });
    // the address comes from the event, because `updateSoon` may have replaced the page's address since the event was made
    addEventListener("hashchange", ({ newURL }) => this.#apply(new URL(newURL).hash));
  }

  /** Return the address; it contains the present time of the motion if the motion is paused, but not at its start or its end. */
  get text() {
    const { changes, choice, openScene, clock, comparedMotions } = this;
    const paused = clock.recording && !clock.playing && !clock.hasEnded ? clock.time : 0;
    const { pins = comparedMotions.pinsOf(changes.scene), time = paused } = this.#awaited;
    const hash = hashOf(changes, {
      scene: openScene.text,
      curves: choice.names.join(),
      pins: pins.map((pin) => pin.letter + nameInAddress(pin) + AFTER_LETTER + hashOf(changes, {}, pin)).join(BETWEEN_PINS),
      time: time && numberText(Number(time.toFixed(7))),
      view: this.#awaited.view ?? this.#view,
    });
    return location.href.split("#")[0] + (hash && `#${hash}`);
  }

  /** Return the switches that differ from those of a new page, and the speed if it does, as text for the address. */
  get #view() {
    const { on, speed } = this.#usual;
    const differing = SWITCHES.filter((id) => isOn(id) !== on.includes(id));
    return [...differing, byId("speed").value !== speed && byId("speed").value].filter(Boolean).join();
  }

  /** Set switches and speed as the text `view` of an address tells; a switch or speed that it does not name is as on a new page. */
  set #view(view) {
    const [parts, { on, speed }] = [view.split(","), this.#usual];
    SWITCHES.filter((id) => isOn(id) !== (on.includes(id) !== parts.includes(id))).forEach((id) => byId(id).click());
    byId("speed").value = parts.find((part) => Number(part)) ?? speed;
    byId("speed").dispatchEvent(new Event("change"));
  }

  /**
   * Return the `pins` and the `time` of an address that has been used since the last call, and set its switches; without such an address
   * both are undefined. The address has these pins until they are pinned.
   */
  takeAwaited() {
    if (this.#isRunning) return {};
    const awaited = this.#awaited;
    if (awaited.view !== undefined) this.#view = awaited.view;
    this.#isRunning = Boolean(awaited.pins);
    this.#awaited = this.#isRunning ? { pins: awaited.pins } : {};
    return awaited;
  }

  /** Return whether the address lacks any pin, because the pin is of another scene than the open one. */
  get lacksPins() {
    const { changes: { scene }, comparedMotions: { pins } } = this;
    return pins.some((recording) => recording.scene !== scene);
  }

  /** Set the page's address to `text` when nothing has changed for a while: browsers limit how often a page may change its address. */
  updateSoon() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => history.replaceState(null, "", this.text), REST);
  }

  /**
   * Use the scene, the changes and the outputs in the part of an address from "#" on, `hash`. If the scene has a fault, show the fault, and
   * use none of the three. If anything else has a fault, show the fault, and use only the scene.
   */
  #apply(hash) {
    const { changes, choice, openScene } = this;
    try {
      const { scene: text = "", curves = "", pins = "", time = "", view = "", ...parts } = changesIn(hash);
      if (text && text !== openScene.text) openScene.open(contentsIn(text));
      else if (text !== openScene.text) openScene.openFirst();
      const { values, inputSteps } = changedBy(parts, changes);
      const awaited = pins.split(BETWEEN_PINS).filter(Boolean).map((pin) => pinIn(pin, changes));
      choice.take(curves);
      this.#isRunning = false;
      this.#awaited = { view, ...(awaited.length && { pins: awaited }), ...(Number(time) > 0 && { time: Number(time) }) };
      changes.replace(values, inputSteps);
    } catch (error) {
      this.refuse(`The link cannot be used: ${error.message}.`);
      this.updateSoon();
    }
  }
}

/** Return the changes (`values`, `inputSteps`) that parts of an address (`texts`: name → text) make in the present scene. */
function changedBy(texts, changes) {
  const { others, inputSteps } = inputStepsIn(texts, changes);
  return { values: new Changes(changes.scene).with(others), inputSteps };
}

/** Return the name of a pin as it stands in an address, after its letter; "" without a name. */
function nameInAddress({ name }) {
  return name ? BEFORE_NAME + encodeURIComponent(name.replaceAll(/[!~]/g, "")) : "";
}

/** Return the letter, the name and the changes of a pin in an address, such as A~gravity.y=-9 or A:moon~gravity.y=-1.6. */
function pinIn(text, changes) {
  const [, letter, name = "", hash = ""] = new RegExp(`^([A-E])(?:${BEFORE_NAME}([^~]*))?(?:${AFTER_LETTER}(.*))?$`).exec(text) ?? [];
  if (!letter) throw new RangeError(`the pin ${text} must be a letter from A to E, ${AFTER_LETTER} and changes`);
  return { letter, name: decodeURIComponent(name), ...changedBy(changesIn(hash), changes) };
}
