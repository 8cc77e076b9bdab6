// The motions that are drawn behind the present motion: the motion before the last change, and pinned motions, which a table compares.

import { find, make } from "../base/dom.js";
import { LabelSpace, positionsAround } from "../drawing/label_positions.js";
import { STRIP } from "../drawing/scale_strip.js";
import { Recording } from "../recording/recording.js";
import { differenceText, pairsTable, summaryTable } from "./compared_table.js";
import { onGesture } from "./gestures.js";

const COLOURS = 5; // number of colours for pinned motions in the style sheet
const LETTERS = "ABCDE"; // the letters of the colours, because two colours may look alike
const TIP = 15; // [pixels] diameter of the dot of a letter
// distances from its tip at which a letter is tried in this order, as multiples of TIP
const LETTER_DISTANCES = [1.1, 1.6, 2.2, 3, 4, 5, 7];

export class ComparedMotions {
  onPin = () => {}; // a function that is called when a motion has been pinned, or is not pinned any more

  constructor(player, panel, table) {
    this.player = player;
    this.panel = panel;
    this.table = table;
    this.pinned = []; // the pinned motions: {recording, colour}
    this.before = null;
    player.drawing.comparedNow = () => this.marks;
  }

  /**
   * Listen to changes of parameters from now on: the motion that is shown when a gesture begins becomes the motion before the change.
   * `handles`: those with which the reader drags.
   */
  follow(changes, handles) {
    onGesture(changes, handles, (isBegin) => {
      if (isBegin) this.before = this.player.recording ?? null;
      if (changes.scene.name !== this.before?.name) this.before = null; // another scene, not an edited one
    });
  }

  /** Return the recordings to draw behind a new motion: that before the last change, if there is one, and the pinned recordings. */
  get behind() {
    return [this.before, ...this.pins].filter(Boolean);
  }

  get pins() {
    return this.pinned.map(({ recording }) => recording);
  }

  /** Return the pinned motions of a scene, each with its `letter`, `name` and changes from the scene (`values`, `inputSteps`). */
  pinsOf(scene) {
    return this.pinned.filter(({ recording }) => recording.scene === scene)
      .map(({ recording: { values, inputSteps }, colour, name }) => ({ letter: LETTERS[colour - 1], name, values, inputSteps }));
  }

  /** Pin motions in place of those that are pinned; each has a `letter`, a `name` or none, `parts`, and facts `about` it. */
  pinAll(motions) {
    this.#use(motions.map(({ letter, name, parts, about }) => ({
      name,
      recording: Object.assign(new Recording({ ...parts, ownView: parts.view }), about),
      colour: LETTERS.indexOf(letter) + 1,
    })));
  }

  /**
   * Pin the shown motion, and show it in the table, where words for its changes are its name. If a pin has an equal motion, a sentence
   * tells this instead.
   */
  pin() {
    const { recording } = this.player;
    const equal = this.pinned.find((motion) => isSameRun(motion.recording, recording));
    if (equal) {
      find("pin-equal").textContent = `The present motion is the same as pin ${LETTERS[equal.colour - 1]}, so it is not pinned again.`;
      return;
    }
    const used = this.pinned.map(({ colour }) => colour);
    const colour = Array.from({ length: COLOURS }, (_, k) => k + 1).find((k) => !used.includes(k)) ?? 1;
    this.#use([...this.pinned, { recording, colour }]);
    this.panel.scrollIntoView({ block: "nearest" }); // on a small screen the list is below the motion, so it is scrolled into view
  }

  #use(pinned) {
    this.pinned = pinned;
    this.show();
    this.onPin();
    this.player.drawSoon();
  }

  /** Return the reader's name for a pinned motion or, without one, words: its scene, if the shown motion has another, and its changes. */
  #textOf({ recording, name: given }) {
    if (given) return given;
    const { name, scene } = recording;
    const { name: shownName, scene: shown } = this.player.recording;
    const text = this.#changesOf(recording);
    if (isSame(scene.file, shown.file)) return text || "as in the scene";
    return [name === shownName ? "another scene" : name, text].filter(Boolean).join(", ");
  }

  /** Return words for the changes of a motion, as `differingText` compares them with those of the shown motion and of all pinned ones. */
  #changesOf(motion) {
    return differingText(motion, [this.player, ...this.pinned].map(({ recording }) => recording.changed));
  }

  unpin({ recording }) {
    this.#use(this.pinned.filter((other) => other.recording !== recording));
  }

  /**
   * Return the compared motions at the present time: each with its `recording`, `frame`, `kind` (class of the style sheet), `positions` of
   * its link ends on the screen, `letter` (undefined for the motion before the last change) and `at`, the position of the letter.
   */
  get #shown() {
    const { drawing: { camera, size }, clock, recording: shown } = this.player;
    const pointsOf = (recording, frame) =>
      Array.from({ length: recording.links + 1 }, (_, point) => camera.toScreen(...recording.pointAt(frame, point)));
    const space = new LabelSpace(...size, STRIP); // for letters
    const chain = pointsOf(shown, shown.frameAt(clock.time));
    space.reserveLine(chain);
    chain.forEach((joint) => space.reserveAround(joint));
    const pinned = this.pinned.map(({ recording, colour }) => ({ recording, kind: `pin-${colour}`, letter: LETTERS[colour - 1] }));
    // the motion before the last change is not drawn where a pinned motion or the present one equals it
    const isDrawn = this.before && ![shown, ...this.pins].some((other) => isSameRun(this.before, other));
    const others = pinned.filter(({ recording }) => recording !== shown);
    if (isDrawn) others.unshift({ recording: this.before, kind: "before" });
    return others.map(({ recording, kind, letter }) => {
      const frame = recording.frameAt(clock.time);
      const positions = pointsOf(recording, frame);
      const at = letter ? placeOfLetter(positions[recording.traced], space, size) : positions[recording.traced];
      return { recording, frame, kind, letter, positions, at };
    });
  }

  /** Return the positions [pixels] on the screen of the letters of pinned motions, and the lines of the links of all compared motions. */
  get marks() {
    const shown = this.behind.length ? this.#shown : [];
    const lines = shown.flatMap(({ positions }) => positions.slice(1).map((end, k) => [positions[k], end]));
    return { letters: shown.filter(({ letter }) => letter).map(({ at }) => at), lines };
  }

  /** Draw the bodies, links and tips of the compared motions at the present time behind the present motion, and their letters above it. */
  draw() {
    const { behind, letters, camera } = this.player.drawing;
    [behind, letters].forEach((group) => group.clear());
    const shown = this.#shown;
    for (const { recording, frame, kind, positions } of shown) {
      recording.bodiesAt(frame, this.player.recording).forEach((corners) => {
        behind.polygon(corners.map((corner) => camera.toScreen(...corner))).addClass(`compared ${kind}`).fill("none");
      });
      if (recording.ball !== null && recording.radius > 0) {
        behind.circle(2 * recording.radius * camera.scale).center(...positions[recording.ball]).addClass(`compared ${kind}`).fill("none");
      }
      if (!recording.isPoint) behind.polyline(positions).addClass(`compared ${kind}`).fill("none");
    }
    for (const { recording, kind, letter, positions, at: [x, y] } of shown) {
      const [tip, group] = [positions[recording.traced], letter ? letters : behind];
      if (Math.hypot(tip[0] - x, tip[1] - y) > 1) group.line([tip, [x, y]]).addClass(`pin-leader ${kind}`);
      group.circle(letter ? TIP : 8).center(x, y).addClass(`compared-tip ${kind}`);
      if (letter) group.plain(letter).attr({ x, y: y + 4 }).addClass("compared-letter");
    }
  }

  /** Words for what the last change did to the impacts; with pins they name the pin before the change, and are "" if it is not pinned. */
  get #changeText() {
    const text = differenceText(this.before, this.player.recording);
    if (!text || !this.pinned.length) return text;
    const pin = this.pinned.find(({ recording }) => isSameRun(recording, this.before));
    return pin ? `from ${LETTERS[pin.colour - 1]}: ${text.replace(", largest", ",")}` : ""; // one line has no room for the word
  }

  /** Show the curves of the pinned motions in the charts, and list the impacts of the present and the pinned motions side by side. */
  show() {
    const { pinned, panel, table, player } = this;
    find("pin-equal").textContent = "";
    find("impacts-before").textContent = this.#changeText;
    const lines = pinned.map(({ recording, colour }) => ({ recording, stroke: `pin-${colour}`, letter: LETTERS[colour - 1] }));
    player.panels.forEach(([, , chart]) => chart.compare(lines));
    panel.hidden = pinned.length === 0;
    // while the table of pinned motions is shown, the cards beside the motion may be lower (explore.css)
    document.body.classList.toggle("with-pins", !panel.hidden);
    if (panel.hidden) return;
    const [present, ...names] = this.names;
    const all = [{ ...present, recording: player.recording }, ...pinned.map((motion, k) => ({ ...names[k], ...motion }))];
    const isPresent = !document.body.classList.contains("stale"); // else the present values have no motion
    const open = make("button", { type: "button", id: "pairs-open", textContent: "Impact by impact…", ariaHasPopup: "dialog" });
    open.addEventListener("click", () => {
      const named = all.map((motion) => ({ ...motion, name: make("span", { className: "pin-title" }, ...this.#nameOf(motion)) }));
      find("pairs-table").replaceChildren(...pairsTable(named, isPresent));
      find("pairs").showModal();
    });
    table.replaceChildren(...summaryTable(all.map((motion) => ({ ...motion, title: this.#title(motion) })), open, isPresent));
  }

  /** Return the names of the present motion and of the pins, {text, letter, stroke (name of a colour)}; an empty list without pins. */
  get names() {
    if (!this.pinned.length) return [];
    const text = ["present", this.#changesOf(this.player.recording)].filter(Boolean).join(": ");
    const nameOf = (motion) => ({ text: this.#textOf(motion), letter: LETTERS[motion.colour - 1], stroke: `pin-${motion.colour}` });
    return [{ text }, ...this.pinned.map(nameOf)];
  }

  /** Return the elements for the name of a motion: a dot with its letter, and its text. */
  #nameOf({ text, colour, letter = "" }) {
    const dot = make("span", { className: `dot ${colour ? `pin-${colour}` : "present"}`, textContent: letter });
    return [dot, make("span", { className: "pin-text", textContent: text })];
  }

  /** Let the reader write a name for a pinned motion in place of the `button` with its text; without a name it has words again. */
  #rename({ recording, name = "" }, button) {
    const field = make("input", { className: "pin-field", value: name, placeholder: "Name", maxLength: 40, ariaLabel: "Name of this pin" });
    field.addEventListener("keydown", ({ key }) => {
      if (key === "Escape") field.value = name;
      if (["Enter", "Escape"].includes(key)) field.blur();
    });
    field.addEventListener("blur", () => {
      const given = field.value.trim();
      this.#use(this.pinned.map((one) => (one.recording === recording ? { ...one, name: given } : one)));
    }, { once: true });
    button.replaceWith(field);
    field.select();
  }

  #title(motion) {
    const { text, colour } = motion;
    const title = make("span", { className: "pin-title" }, ...this.#nameOf(motion));
    if (!colour) {
      title.classList.add("without-name"); // only a pin has a name
    } else {
      title.prepend(make("span", { className: `dashes pin-${colour}`, title: "In the charts" }));
      const button = make("button", { type: "button", className: "unpin", textContent: "×", title: "Take this pin away" });
      button.addEventListener("click", () => this.unpin(motion));
      const words = title.querySelector(".pin-text");
      const name = make("button", { type: "button", className: "pin-name", title: "Give this pin a name" }, words);
      name.addEventListener("click", () => this.#rename(motion, name));
      title.append(name, button);
    }
    return make("th", { scope: "row", title: motion.name ? this.#changesOf(motion.recording) : text }, title);
  }
}

/**
 * Return words for the parameters in which a motion with the changes `changed` differs from another motion or, if it differs in none, for
 * all its changes; "" for a motion without changes. `all`: the changes of all motions; `unchangedText`: the texts of the motion's other
 * parameters. Parameters with more different values in the changed motions come first, because the end of a long text may be cut off.
 */
function differingText({ changed, unchangedText }, all) {
  if (!changed.size) return "";
  const names = [...new Set(all.flatMap((one) => [...one.keys()]))];
  const valuesOf = (name) => new Set(all.filter(({ size }) => size).map((one) => one.get(name))).size;
  const differing = names.filter((name) => all.some((one) => one.get(name) !== changed.get(name)))
    .sort((one, other) => valuesOf(other) - valuesOf(one));
  const textOf = (name) => {
    const text = changed.get(name) ?? unchangedText(name);
    return text ? `${name} = ${text}` : `${name} as in the scene`; // a parameter that this motion's scene lacks has no text
  };
  return (differing.length ? differing : [...changed.keys()]).map(textOf).join(", ");
}

/** Return whether two complete scene files have equal contents. */
function isSame(file, other) {
  return file === other || JSON.stringify(file) === JSON.stringify(other);
}

/** Return whether two recordings are of one run: of the same scene with the same changes. */
function isSameRun(one, other) {
  const keyOf = ({ values, inputSteps }) => JSON.stringify([Object.entries(values).sort(), inputSteps]);
  return one === other || (one.scene === other.scene && keyOf(one) === keyOf(other));
}

/**
 * Return a position on the screen for a letter: that of its tip or the nearest one around it (LETTER_DISTANCES) that is free in `space`,
 * and reserve it there. Without any, it is the tip's position inside the drawing, which has the given size.
 */
function placeOfLetter(tip, space, size) {
  const around = [{ at: tip }, ...positionsAround(tip, [1, 0], TIP, LETTER_DISTANCES)];
  const free = space.findPosition("A", TIP, around.map(({ at }) => ({ at, anchor: "middle" })));
  return free?.at ?? tip.map((value, axis) => Math.min(Math.max(value, TIP / 2), size[axis] - TIP / 2));
}
