// Begins the two slowest tasks before the page reads its libraries: compiling the kernel, and starting the first worker. The page counts as
// loaded when it shows its first motion, so that a program that takes a picture of the loaded page takes the motion.

import { decompressed } from "../base/base64.js";
import { byId, make } from "../base/dom.js";
import { Engine } from "../solver/engine.js";

const LONGEST_LOAD = 5000; // [ms] a page without a motion counts as loaded after this time
const NEED_MOTION = "#play, #previous, #next, #pin"; // buttons that do nothing without a motion

const needed = ["Worker", "WebAssembly", "DecompressionStream"].filter((name) => !(name in window));
if (needed.length) throw new Error(`this browser has no ${needed.join(", no ")}`);
const program = decompressed(byId("worker").textContent)
  .then((text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
const compiled = decompressed(byId("kernel").textContent).then((bytes) => WebAssembly.compile(bytes));
const startEngine = () => new Engine(program, compiled);
// the page counts as not loaded while it contains this frame, because the document of the frame is open
const unloaded = make("iframe", { hidden: true });
document.documentElement.append(unloaded);
unloaded.contentDocument.open();
setTimeout(() => unloaded.remove(), LONGEST_LOAD);
// presses of buttons wait until the program of the page has begun or, if the buttons NEED_MOTION, until its first run has ended
const pressed = [];
let early = "button";
const wait = (event) => {
  const button = event.target.closest(early);
  if (!button) return;
  event.stopPropagation();
  pressed.push(button);
};
document.addEventListener("click", wait, true);
const beginProgram = () => {
  early = NEED_MOTION;
  pressed.splice(0).forEach((button) => button.click());
};
const finishLoad = (isPlaying) => {
  unloaded.remove();
  document.removeEventListener("click", wait, true);
  pressed.splice(0).filter(({ id }) => id !== "play" || !isPlaying).forEach((button) => button.click());
};
window.begun = { startEngine, engines: [startEngine()], beginProgram, finishLoad };
