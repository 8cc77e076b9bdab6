// Connects the buttons, the slider of time and the keys of the player with its clock.

import { byId } from "../base/dom.js";
import { fixed, speedText } from "../base/format.js";
import { store, stored } from "../base/storage.js";
import { connectTabs } from "../base/tabs.js";
import { SPEEDS } from "./clock.js";

// key → the button or box that it presses
const BUTTON_KEYS = {
  s: "slow", t: "trace", l: "loop", f: "full", z: "at-contact",
  p: "pin", e: "edit-open", m: "map-open", c: "curves-open", x: "export-open",
};

/**
 * Connect buttons, slider and keys with the clock. Without a recording, the slider, the buttons that change the time, and all keys but
 * e, m, x and / do nothing. Return a function that must be called when the clock has another recording.
 */
export function connect(clock, drawing, zoom) {
  const actions = {
    " ": () => clock.toggle(),
    ArrowLeft: () => clock.step(-1),
    ArrowRight: () => clock.step(1),
    ShiftArrowLeft: () => clock.stepImpact(-1),
    ShiftArrowRight: () => clock.stepImpact(1),
    ArrowUp: () => clock.shift(1),
    ArrowDown: () => clock.shift(-1),
    Home: () => clock.seek(clock.recording.start),
    End: () => clock.seek(clock.recording.end),
    "+": () => zoom.press(1),
    "=": () => zoom.press(1),
    "-": () => zoom.press(-1),
    0: () => zoom.fit(),
    "?": () => byId("help").showModal(),
    "/": () => {
      if (!byId("parameters")?.checkVisibility()) byId("parameters-fold")?.click();
      byId("list-of-parameters")?.setAttribute("open", "");
      document.querySelector("#list-of-parameters input")?.focus();
    },
  };
  // the page of a recording lacks some of the buttons
  Object.entries(BUTTON_KEYS).forEach(([key, id]) => {
    actions[key] ??= () => byId(id)?.click();
  });
  document.addEventListener("keydown", (event) => {
    const name = event.shiftKey && event.key.startsWith("Arrow") ? `Shift${event.key}` : event.key;
    const action = actions[name.length === 1 ? name.toLowerCase() : name];
    const isReady = (clock.recording && !document.querySelector("footer").inert) || "emx/".includes(name);
    const isOff = name.length === 1 && name !== " " && !byId("shortcuts").checked;
    if (!action || isOff || !isReady || event.ctrlKey || event.altKey || event.metaKey || keepsKey(event)) return;
    event.preventDefault();
    action();
  });
  const buttons = { play: actions[" "], previous: actions.ShiftArrowLeft, next: actions.ShiftArrowRight };
  Object.entries(buttons).forEach(([id, action]) => byId(id).addEventListener("click", () => clock.recording && action()));
  byId("slow").addEventListener("change", ({ target }) => clock.set({ slow: target.checked }));
  byId("loop").addEventListener("change", ({ target }) => clock.set({ loop: target.checked }));
  byId("full").hidden = !document.fullscreenEnabled;
  byId("full").addEventListener("click", () =>
    (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen()));
  byId("trace").addEventListener("change", ({ target }) => {
    drawing.showTrace = target.checked;
    clock.set({});
  });
  connectTabs(byId("help-tabs"));
  byId("help-open").addEventListener("click", () => byId("help").showModal());
  keepShortcuts();
  pauseBehindDialogs(clock);
  connectSpeed(clock);
  return connectSlider(clock);
}

/** Return whether a key is left to the element with the focus or to an open dialog: a text field, for example, uses most keys itself. */
function keepsKey({ target, key }) {
  if (byId("help").open || target.closest("dialog:modal")) return true;
  if (target.closest("dialog[open]") && /^(Arrow|Page|Home$|End$|Enter$)/.test(key)) return true; // of the map beside the motion
  if (target.closest("input[type=range]:not(#scrub)")) return /^(Arrow|Page|Home$|End$)/.test(key); // these keys move the slider
  if (target.closest("input:not([type=checkbox], [type=range])")) return true;
  if (target.closest("select")) return true;
  return key === " " && target.closest("summary, button, input[type=checkbox]") !== null;
}

/** Keep in the browser whether keys of one letter, digit or sign act: each may be pressed by chance, or by voice control. */
function keepShortcuts() {
  const box = byId("shortcuts");
  box.checked = stored("shortcuts") !== "off";
  box.addEventListener("change", () => store("shortcuts", box.checked ? "on" : "off"));
}

/** Pause while a dialog covers the motion, and go on afterwards. */
function pauseBehindDialogs(clock) {
  let isPaused = false;
  const watch = new MutationObserver(() => {
    const isCovered = document.querySelector("dialog:modal") !== null;
    const isNext = isCovered && (isPaused || clock.playing);
    if (isNext !== isPaused) clock.set({ playing: !isNext });
    isPaused = isNext;
  });
  document.querySelectorAll("dialog").forEach((dialog) => watch.observe(dialog, { attributeFilter: ["open"] }));
}

function connectSpeed(clock) {
  const select = byId("speed");
  const choices = SPEEDS.includes(clock.speed) ? SPEEDS : [...SPEEDS, clock.speed].sort((a, b) => a - b);
  select.append(...choices.map((value) => new Option(speedText(value), String(value))));
  select.addEventListener("change", () => clock.set({ speed: Number(select.value) }));
  const show = () => {
    select.value = String(clock.speed);
    if (clock.recording) select.title = `The whole motion takes ${fixed(clock.duration, 1)} s on the screen`;
  };
  clock.onChange(show);
  show();
}

function connectSlider(clock) {
  const slider = byId("scrub");
  slider.addEventListener("input", () => clock.recording && clock.seek(Number(slider.value)));
  const play = byId("play");
  clock.onChange(() => {
    const { recording } = clock;
    slider.value = String(clock.time);
    slider.setAttribute("aria-valuetext", `${clock.time.toFixed(4)} s`);
    slider.style.setProperty("--done", `${(100 * (clock.time - recording.start)) / (recording.end - recording.start)}%`);
    const label = clock.playing ? "Pause" : "Play";
    if (play.getAttribute("aria-label") !== label) play.setAttribute("aria-label", label);
  });
  const marks = byId("marks");
  // size and colour of the canvas with marks, read only when they may have changed: reading them makes the browser lay out the page
  let look;
  const draw = () => clock.recording && look && drawMarks(marks, look, clock.recording);
  const fit = () => {
    look = { width: marks.clientWidth, height: marks.clientHeight, colour: getComputedStyle(marks).color };
    draw();
  };
  new ResizeObserver(fit).observe(marks.parentElement);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", fit);
  return () => {
    Object.assign(slider, { min: clock.recording.start, max: clock.recording.end });
    draw();
  };
}

/** Draw a mark for each impact of a recording above the slider; its height is in proportion to `linearSpeed`, but at least `lowest`. */
function drawMarks(canvas, { width, height, colour }, { impacts, start, end }) {
  const density = window.devicePixelRatio;
  Object.assign(canvas, { width: width * density, height: height * density });
  const context = canvas.getContext("2d");
  context.scale(density, density);
  context.fillStyle = colour;
  const fastest = impacts.reduce((most, { linearSpeed }) => Math.max(most, linearSpeed), 1e-12);
  const thumb = 16; // [pixels] width of the slider's thumb: its middle stays half of this away from both ends of the slider
  const lowest = 5; // [pixels] least height of the mark of an impact above the slider
  for (const { onset, linearSpeed } of impacts) {
    const x = thumb / 2 + ((width - thumb) * (onset - start)) / (end - start);
    const tall = Math.max(lowest, (height * linearSpeed) / fastest);
    context.fillRect(x - 1, height - tall, 2, tall);
  }
}
