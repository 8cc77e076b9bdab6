// The motions that are drawn behind the present motion: the motion before the last change, and pinned motions, which a table compares.

import { byId, make } from "../base/dom.js";
import { LabelSpace, positionsAround } from "../drawing/label_positions.js";
import { STRIP } from "../drawing/scale_strip.js";
import { partingTime } from "../recording/parting.js";
import { Recording } from "../recording/recording.js";
import { differenceText, pairsTable, summaryTable } from "./compared_table.js";
import { onGesture } from "./gestures.js";

const COLOURS = 5; // number of colours for pinned motions in the style sheet
const LETTERS = "ABCDE"; // the letters of the colours, because two colours may look alike
const LONGEST_LINE = 52; // [characters] a line of a picture's caption fits into a card of the page
const TIP = 15; // [pixels] diameter of the dot of a letter
// distances from its tip at which a letter is tried in this order, as multiples of TIP
const LETTER_DISTANCES = [1.6, 2.2, 3, 4, 5, 7];
const [SAME_TIP, LETTERS_BESIDE] = [3, 17]; // [pixels] letters of tips that are nearer than SAME_TIP stand beside each other

export class ComparedMotions {
  onPin = () => {}; // a function that is called when a motion has been pinned, or is not pinned any more

  constructor(player, panel, table) {
    this.player = player;
    this.panel = panel;
    this.table = table;
    this.pinned = []; // the pinned motions: {recording, colour}
    this.before = null;
    this.reference = undefined; // the pinned recording that the reader compares with, null for the present one; undefined: the first pin
    player.drawing.comparedNow = () => this.marks;
  }

  /**
   * Listen to changes of parameters from now on: the motion that is shown when a gesture begins becomes the motion before the change, but
   * not if it is of a scene with another name. `handles`: those with which the reader drags.
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
      byId("pin-equal").textContent = `The present motion is the same as pin ${LETTERS[equal.colour - 1]}, so it is not pinned again.`;
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

  /** Return words for the changes of a motion, as `valuesText` compares them with those of the shown motion and of all pinned ones. */
  #changesOf(motion) {
    return motion.changed.size ? valuesText(motion, this.#changed) : "";
  }

  get #changed() {
    return [this.player, ...this.pinned].map(({ recording }) => recording.changed);
  }

  unpin({ recording }) {
    this.#use(this.pinned.filter((other) => other.recording !== recording));
  }

  /**
   * Return the compared motions at the present time: each with its `recording`, `frame`, `kind` (class of the style sheet), `positions` of
   * its link ends on the screen, `letter` (undefined for the motion before the last change), `at`, the position of the letter, and whether
   * a line leads there from the tip (`hasLeader`).
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
    const placed = []; // the letters with a line to their tip
    return others.map(({ recording, kind, letter }) => {
      const frame = recording.frameAt(clock.time);
      const positions = pointsOf(recording, frame);
      const tip = positions[recording.traced];
      const first = letter && placed.find(({ tip: [x, y] }) => Math.hypot(x - tip[0], y - tip[1]) < SAME_TIP);
      const beside = first && placeBeside(first.at, space);
      const at = letter ? beside ?? placeOfLetter(tip, space, size) : tip;
      if (letter && !beside) placed.push({ tip, at });
      return { recording, frame, kind, letter, positions, at, hasLeader: !beside };
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
    for (const { recording, kind, letter, positions, at: [x, y], hasLeader } of shown) {
      const [tip, group] = [positions[recording.traced], letter ? letters : behind];
      if (hasLeader && Math.hypot(tip[0] - x, tip[1] - y) > 1) group.line([tip, [x, y]]).addClass(`pin-leader ${kind}`);
      group.circle(letter ? TIP : 8).center(x, y).addClass(`compared-tip ${kind}`);
      if (letter) group.plain(letter).attr({ x, y: y + 4 }).addClass("compared-letter");
    }
  }

  /** Return the index of the motion with which all others are compared: 0 for the present one, then the pinned motions. */
  get #referenceIndex() {
    const chosen = this.pins.indexOf(this.reference) + 1;
    return this.reference === null ? 0 : chosen || 1;
  }

  /** Words for what the last change did to the impacts or, with pins, for how they differ from those of the reference, which they name. */
  get #changeText() {
    if (!this.pinned.length) return differenceText(this.before, this.player.recording);
    const pin = this.pinned[this.#referenceIndex - 1];
    const text = pin && differenceText(pin.recording, this.player.recording);
    return text ? `from ${LETTERS[pin.colour - 1]}: ${text.replace(", largest", ",")}` : ""; // one line has no room for the word
  }

  /** Return the time at which a pinned motion parts from the reference or, for the reference itself, from the present motion. */
  #partingOf(recording) {
    const reference = [this.player.recording, ...this.pins][this.#referenceIndex];
    return partingTime(reference, recording === reference ? this.player.recording : recording);
  }

  /** Show the curves of the pinned motions in the charts, and list the impacts of the present and the pinned motions side by side. */
  show() {
    const { pinned, panel, table, player } = this;
    byId("pin-equal").textContent = "";
    byId("impacts-before").textContent = this.#changeText;
    const lines = pinned.map(({ recording, colour }) =>
      ({ recording, stroke: `pin-${colour}`, letter: LETTERS[colour - 1], parting: this.#partingOf(recording) }));
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
      byId("pairs-table").replaceChildren(...pairsTable(named, isPresent));
      byId("pairs").showModal();
    });
    const [reference, isChosen] = [this.#referenceIndex, document.activeElement?.name === "reference"];
    const titled = all.map((motion, k) => ({ ...motion, title: this.#title(motion, k === reference) }));
    table.replaceChildren(...summaryTable(titled, { reference, button: open, isPresent }));
    if (isChosen) table.querySelector(":checked").focus();
  }

  /** Return the names of the present motion and of the pins, {text, letter, stroke (name of a colour)}; an empty list without pins. */
  get names() {
    if (!this.pinned.length) return [];
    const text = ["present", this.#changesOf(this.player.recording)].filter(Boolean).join(": ");
    const nameOf = (motion) => ({ text: this.#textOf(motion), letter: LETTERS[motion.colour - 1], stroke: `pin-${motion.colour}` });
    return [{ text }, ...this.pinned.map(nameOf)];
  }

  /** Return the lines of a picture's caption below its title: `names` or, without pins, the changes of the shown motion. */
  get caption() {
    const { recording } = this.player;
    const lines = this.pinned.length ? [] : captionLines(recording ? this.#changesOf(recording) : "");
    return [...this.names, ...lines.map((text) => ({ text }))];
  }

  /** Return the elements for the name of a motion: a dot with its letter, and its text. */
  #nameOf({ text, colour, letter = "" }) {
    const dot = make("span", { className: `dot ${colour ? `pin-${colour}` : "present"}`, textContent: letter });
    const words = text.split(/(?<= = )(.*?)(?=, |$)/).map((part, k) => (k % 2 ? make("b", { textContent: part }) : part));
    return [dot, make("span", { className: "pin-text" }, ...words)];
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

  /** Return the first cell of a row: a switch that makes its motion the reference, its name, and what differs beside a given name. */
  #title(motion, isReference) {
    const { text, colour, name: given, recording } = motion;
    const letter = colour ? LETTERS[colour - 1] : "present";
    const reference = make("input", { type: "radio", name: "reference", checked: isReference, ariaLabel: `Compare with ${letter}` });
    reference.title = "Compare all motions with this one";
    reference.addEventListener("change", () => {
      this.reference = colour ? recording : null;
      this.show();
    });
    const [dot, words] = this.#nameOf(motion);
    // a name, or the words for a motion as in the scene, do not tell the values
    const values = given || !recording.changed.size ? valuesText(recording, this.#changed) : "";
    const parts = [words, ...(values ? [make("small", { className: "pin-values", textContent: values })] : [])];
    const title = make("span", { className: "pin-title" }, reference);
    if (!colour) {
      title.classList.add("without-name"); // only a pin has a name
      title.append(dot, make("span", {}, ...parts));
    } else {
      const button = make("button", { type: "button", className: "unpin", textContent: "×", title: "Take this pin away" });
      button.addEventListener("click", () => this.unpin(motion));
      const name = make("button", { type: "button", className: "pin-name", title: "Give this pin a name" }, ...parts);
      name.addEventListener("click", () => this.#rename(motion, name));
      title.append(make("span", { className: `dashes pin-${colour}`, title: "In the charts" }), dot, name, button);
    }
    return make("th", { scope: "row", title: motion.name ? this.#changesOf(motion.recording) : text }, title);
  }
}

/**
 * Return words for the parameters in which a motion with the changes `changed` differs from another motion or, if it differs in none, for
 * all its changes. `all`: the changes of all motions; `unchangedText`: a function that returns the text of another parameter of the motion.
 * Parameters with more different values in the changed motions come first.
 */
function valuesText({ changed, unchangedText }, all) {
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

/** Return lines, if possible of at most LONGEST_LINE characters, for a text with parts between commas that begin with capitals. */
function captionLines(text) {
  return text.split(/, (?=\p{Lu})/u).filter(Boolean).reduce((lines, part) => {
    const longer = [lines.at(-1), part].filter(Boolean).join(", ");
    return longer.length > LONGEST_LINE ? [...lines, part] : [...lines.slice(0, -1), longer];
  }, []);
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

/** Return a free position for a letter in one row with the letter at [x, y], of which the tip is the same; undefined without one. */
function placeBeside([x, y], space) {
  const row = [1, -1, 2, -2, 3, -3, 4, -4].map((place) => ({ at: [x + place * LETTERS_BESIDE, y], anchor: "middle" }));
  return space.findPosition("A", TIP, row)?.at;
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
