// Buttons, the slider and the keys.

import { SPEEDS } from "./clock.js";
import { speedText } from "./format.js";

const get = (id) => document.getElementById(id);

/** Connect buttons, slider and keys with the clock; returns what is to be called when it has another recording. */
export function connect(clock, scene) {
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
    s: () => get("slow").click(),
    t: () => get("trace").click(),
    "?": () => get("help").showModal(),
  };
  document.addEventListener("keydown", (event) => {
    const name = event.shiftKey && event.key.startsWith("Arrow") ? `Shift${event.key}` : event.key;
    const action = actions[name.length === 1 ? name.toLowerCase() : name];
    if (!action || event.ctrlKey || event.altKey || event.metaKey || keepsKey(event)) return;
    event.preventDefault();
    action();
  });
  get("play").addEventListener("click", () => clock.toggle());
  get("previous").addEventListener("click", () => clock.stepImpact(-1));
  get("next").addEventListener("click", () => clock.stepImpact(1));
  get("slow").addEventListener("change", ({ target }) => clock.set({ slow: target.checked }));
  get("trace").addEventListener("change", ({ target }) => {
    scene.showTrace = target.checked;
    clock.set({});
  });
  get("help-open").addEventListener("click", () => get("help").showModal());
  connectSpeed(clock);
  return connectSlider(clock);
}

/** Whether the element that has the focus needs the key itself. */
function keepsKey({ target, key }) {
  if (get("help").open || target.closest("dialog")) return true;
  if (target.closest("input:not([type=checkbox], #scrub)")) return true;
  if (target.closest("select")) return true;
  return key === " " && target.closest("summary, button, input[type=checkbox]") !== null;
}

function connectSpeed(clock) {
  const select = get("speed");
  const choices = SPEEDS.includes(clock.speed) ? SPEEDS : [...SPEEDS, clock.speed].sort((a, b) => a - b);
  select.append(...choices.map((value) => new Option(speedText(value), String(value))));
  select.addEventListener("change", () => clock.set({ speed: Number(select.value) }));
  clock.onChange(() => {
    select.value = String(clock.speed);
  });
}

function connectSlider(clock) {
  const slider = get("scrub");
  slider.addEventListener("input", () => clock.seek(Number(slider.value)));
  const play = get("play");
  clock.onChange(() => {
    const { recording } = clock;
    slider.value = String(clock.time);
    slider.setAttribute("aria-valuetext", `${clock.time.toFixed(4)} s`);
    slider.style.setProperty("--done", `${(100 * (clock.time - recording.start)) / (recording.end - recording.start)}%`);
    const label = clock.playing ? "Pause" : "Play";
    if (play.getAttribute("aria-label") !== label) play.setAttribute("aria-label", label);
  });
  const marks = get("marks");
  const draw = () => clock.recording && drawMarks(marks, clock.recording);
  new ResizeObserver(draw).observe(marks.parentElement);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  return () => {
    Object.assign(slider, { min: clock.recording.start, max: clock.recording.end });
    draw();
  };
}

/** A mark above the slider for each impact, the higher the faster it was. */
function drawMarks(canvas, { impacts, start, end }) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const density = window.devicePixelRatio;
  Object.assign(canvas, { width: width * density, height: height * density });
  const context = canvas.getContext("2d");
  context.scale(density, density);
  context.fillStyle = getComputedStyle(canvas).color;
  const fastest = impacts.reduce((most, { endSpeed }) => Math.max(most, endSpeed), 1e-12);
  const thumb = 16; // px: the middle of the slider's thumb stays half of this from its ends
  for (const { onset, endSpeed } of impacts) {
    const x = thumb / 2 + ((width - thumb) * (onset - start)) / (end - start);
    const tall = Math.max(3, (height * endSpeed) / fastest);
    context.fillRect(x - 1, height - tall, 2, tall);
  }
}
