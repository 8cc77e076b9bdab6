// The page that simulates: each change of a parameter gives another motion.

import { decompressed } from "../base/base64.js";
import { find, make } from "../base/dom.js";
import { Player } from "../player/player.js";
import { Recording } from "../recording/recording.js";
import { contentsOf, tomlText } from "../scene/changed_file.js";
import { Changes } from "../scene/changes.js";
import { inputSignals, inputStepsIn, inputStepTexts } from "../scene/input_steps.js";
import { describe } from "../scene/model.js";
import { asWritten, complete, contentsIn } from "../scene/scene_file.js";
import { Engine } from "../solver/engine.js";
import { ComparedMotions } from "./compared_motions.js";
import { CurveChoice } from "./curve_choice.js";
import { Editor } from "./editor.js";
import { changesIn, commandOf, csvOf, hashOf, pictureOf, save } from "./export.js";
import { Handles } from "./handles.js";
import { GridMap } from "./map.js";
import { showParameterList } from "./parameter_list.js";
import { showMainParameters } from "./sliders.js";

const WAITING = 120; // [ms] the time after which an old motion becomes grey
const PATIENCE = 250; // [ms] the time after which the next change ends a run: a slider shows its effect while it is dragged
const REST = 300; // [ms] the time without a change after which the address gets the changes
const KEPT = 0.5; // the least part of the view, in size, that a motion must fill for the view to stay

const { file, kit, command, module: packedModule } = JSON.parse(find("data").textContent);
const pageScene = describe(kit, complete(file, kit), command);
const changes = new Changes(pageScene);
const needed = ["Worker", "WebAssembly", "DecompressionStream"].filter((name) => !(name in window));
if (needed.length) throw new Error(`this browser has no ${needed.join(", no ")}`);
const module = decompressed(packedModule).then((bytes) => WebAssembly.compile(bytes));
const program = URL.createObjectURL(new Blob([find("worker").textContent], { type: "text/javascript" }));
const begin = () => new Engine(program, changes.scene, module);
let engine = begin();
let opened = ""; // the text of the open scene file; empty for the page's own scene
const player = new Player(1);
const comparedMotions = new ComparedMotions(player, find("pins"), find("pin-table"));
const handles = new Handles(player, changes, find("scene"));
player.layers.push(comparedMotions, handles);
const choice = new CurveChoice(changes, () => {
  remember();
  update();
});

/** Return the view before, so that the picture does not move, if the next view lies inside it and is not much smaller. */
function steady(next) {
  const before = player.recording;
  if (!before) return next;
  const size = ({ view: [low, high] }) => Math.max(high[0] - low[0], high[1] - low[1]);
  const isWithin = [0, 1].every((axis) =>
    next.view[0][axis] >= before.view[0][axis] && next.view[1][axis] <= before.view[1][axis]);
  const isKept = handles.dragged !== null; // a handle that is dragged stays below the pointer
  return isKept || (isWithin && size(next) > KEPT * size(before)) ? { ...next, view: before.view, anchor: before.anchor } : next;
}

/** Return a sentence on the fault of a run; "" without a fault. `hasMotion`: whether there is a motion. */
function sentenceOf({ status, reason, reached }, hasMotion) {
  if (status === 0) return "";
  const text = [changes.scene.statuses[status], changes.scene.reasons[reason - 1]].filter(Boolean).join(": ");
  return hasMotion ? `The simulation stopped at t = ${+reached.toPrecision(6)} s: ${text}.` : `The simulation cannot start: ${text}.`;
}

let remembering; // the timer of `remember`
let sentence = ""; // the sentence on the end of the last simulation
let ending = 0; // the status of the last simulation
let notice = ""; // a sentence on a fault in the address, until something changes

function say(next = sentence) {
  sentence = next;
  const all = [notice, sentence].filter(Boolean).join(" ");
  find("status").classList.add("begun");
  find("status").textContent = all;
  find("status").hidden = !all;
  if (ending === kit.rigidWithFriction) find("status").append(" ", withoutFriction());
}

/** Return a button that sets all friction of walls to zero, for a law that does not allow friction. */
function withoutFriction() {
  const button = make("button", { type: "button", className: "action", textContent: "Set the friction of walls to 0" });
  const names = [...changes.parameters.keys()].filter((name) => /^(contact|wall\..*)\.(static_)?friction$/.test(name));
  button.addEventListener("click", () => changes.set(Object.fromEntries(names.map((name) => [name, 0]))));
  return button;
}

let [begun, next] = [-Infinity, 0]; // when the present run began, and the timer of the next one

/** Simulate with the present parameters: at the end of the present run, or when PATIENCE is over. */
function update() {
  clearTimeout(next);
  const left = begun + PATIENCE - performance.now();
  if (left > 0) next = setTimeout(simulateNow, left);
  else simulateNow();
}

/** Simulate with the present parameters and show the motion, unless another run begins meanwhile. */
async function simulateNow() {
  [begun, next] = [performance.now(), 0];
  find("reset-all").hidden = changes.count === 0;
  const text = [...changes.texts(), ...inputStepTexts(changes)].map(([name, value]) => `${name} = ${value}`).join(", ");
  const waiting = setTimeout(() => document.body.classList.add("computing"), WAITING);
  const result = await engine
    .ask("motion", changes.values, { replaces: true, curves: choice.names, inputSteps: changes.inputSteps }, (share) => find("stage").style.setProperty("--share", `${100 * share}%`))
    .catch((error) => ({ parts: null, fault: `The solver cannot work in this browser: ${error.message}.` }));
  clearTimeout(waiting);
  if (!result) return;
  begun = -Infinity;
  document.body.classList.remove("computing");
  document.body.classList.toggle("stale", !result.parts);
  ending = result.status;
  say(result.fault ?? sentenceOf(result, result.parts));
  if (result.parts) {
    player.show(Object.assign(new Recording(steady(result.parts)), { text }));
    comparedMotions.show();
  } else if (player.recording) {
    player.drawSoon();
  }
  if (next) update();
}

/** Return the address of the page with the changes. */
function address() {
  const hash = hashOf(changes, { scene: opened, curves: choice.names.join() });
  return location.href.split("#")[0] + (hash && `#${hash}`);
}

/** Put the changes into the address after a time without changes, because browsers limit such calls. */
function remember() {
  clearTimeout(remembering);
  remembering = setTimeout(() => history.replaceState(null, "", address()), REST);
}

/** Show another scene and its name; `text` is the text of its file, empty for the page's own scene; `inputs` are changed inputs. */
function show(scene, text, inputs) {
  opened = text;
  engine.end();
  changes.open(scene, inputs);
  showWords();
}

/** Open a scene with the contents of a file, and changed inputs; an error says which key is wrong. */
function open(contents, inputs) {
  const whole = complete(contents, kit);
  show(describe(kit, whole, [`${whole.name}.toml`]), tomlText(asWritten(whole, kit.signals.other), kit.keys), inputs);
}

/** Show name and description of the scene, and notes on its inputs: when sliders act, and which inputs are constant here. */
function showWords() {
  const { name, text, still, inputs } = changes.scene;
  document.querySelector("h1").textContent = name;
  document.title = `${name} – chain-impact`;
  find("description").textContent = text;
  find("description").hidden = !text;
  const notes = [
    inputs.length && "While the motion plays, the slider of an input acts from that moment on.",
    still.length && `These inputs keep their start values here: ${still.join(", ")}.`,
  ].filter(Boolean);
  find("inputs").hidden = notes.length === 0;
  find("inputs").textContent = notes.join(" ");
  find("edit-first").hidden = !opened;
}

/** Use the scene and the changes in the address; a fault is shown, and changes nothing. */
function takeAddress() {
  try {
    const { scene: text = "", curves = "", ...parts } = changesIn(location.hash);
    if (text !== opened) {
      if (text) open(contentsIn(text));
      else show(pageScene, "");
    }
    const { others, inputSteps } = inputStepsIn(parts, changes);
    const values = new Changes(changes.scene).with(others);
    choice.take(curves);
    changes.replace(values, inputSteps);
  } catch (error) {
    notice = `The link cannot be used: ${error.message}.`;
    remember();
    say();
  }
}

function connectExport() {
  const fill = () => Object.assign(find("command"), { value: commandOf(changes) }) && Object.assign(find("link"), { value: address() });
  find("export-open").addEventListener("click", () => {
    fill();
    find("export-text").textContent = opened ? "The command needs the scene file: save it first." : "";
    find("export").showModal();
  });
  document.querySelectorAll("[data-copy]").forEach((button) => button.addEventListener("click", async () => {
    const field = find(button.dataset.copy);
    field.select();
    const copied = navigator.clipboard?.writeText(field.value) ?? Promise.reject(new Error("no clipboard"));
    await copied.catch(() => document.execCommand("copy"));
    button.textContent = "Copied";
    setTimeout(() => Object.assign(button, { textContent: "Copy" }), 1500);
  }));
  connectFile("csv", async () => {
    const result = await engine.ask("rows", { ...changes.values }, { inputSteps: changes.inputSteps });
    save(new Blob([csvOf(result)], { type: "text/csv" }), `${changes.scene.name}.csv`);
    return sentenceOf(result, result.time.length > 0);
  });
  connectFile("toml", async () => {
    save(new Blob([tomlText(contentsOf(changes, inputSignals(changes)), kit.keys)], { type: "application/toml" }), `${changes.scene.name}.toml`);
    return "";
  });
  connectFile("png", async () => {
    const background = getComputedStyle(document.body).backgroundColor;
    save(await pictureOf(find("scene"), background), `${changes.scene.name}.png`);
    return "";
  });
}

/** Let a button save a file, and show a message about it. */
function connectFile(id, write) {
  find(id).addEventListener("click", async () => {
    find("export-text").textContent = await write().catch((error) => `${error.message}.`);
  });
}

/** The interface for the console, and for other pages that contain this page. */
window.chainImpact = {
  get scene() {
    return changes.scene.name;
  },
  /** Return the present values of all parameters: name → value; for a choice, its name. */
  get parameters() {
    return Object.fromEntries(changes.texts(Object.fromEntries(changes.scene.parameters.map(({ name }) => [name, changes.valueOf(name)]))));
  },
  /** Simulate the scene with some parameters changed, independently of the page: {time, columns, impacts, statistics}. */
  async simulate(given = {}, { output } = {}) {
    const { scene } = changes;
    const values = new Changes(scene).with(given);
    if (output && !Array.isArray(output)) throw new TypeError("output must be a list of names");
    const unknown = output?.find((name) => !scene.columns.some((column) => column.name === name));
    if (unknown) throw new RangeError(`${unknown} is no output`);
    const result = await engine.ask("rows", values, { names: output });
    const { time, columns, impacts, statistics, status, reached } = result;
    const named = impacts.map((impact) => ({ ...impact, wall: scene.wallNames[impact.wall] }));
    const run = { time, columns, impacts: named, statistics };
    if (status !== 0) {
      const fault = `the simulation stopped at t = ${+reached.toPrecision(9)} s: ${changes.scene.statuses[status]}`;
      throw Object.assign(new Error(fault), { status, time: reached, result: run });
    }
    return run;
  },
  /** Let the page show the scene with some more parameters changed. */
  show(given = {}) {
    changes.set(given);
  },
};

let grid; // the map is made when it is first opened; it has other workers than the motion
find("map-open").addEventListener("click", () => {
  grid ??= new GridMap(begin, changes);
  grid.open();
});
changes.onOpen(() => {
  engine = begin();
});
new Editor(changes, open, () => show(pageScene, ""));
showWords();
const presentTime = () => ({ isPlaying: player.clock.playing, time: player.recording ? player.clock.time : 0 });
player.layers.push({ draw: showMainParameters(find("main-parameters"), changes, presentTime) });
showParameterList(find("list-of-parameters"), changes);
connectExport();
find("reset-all").addEventListener("click", () => changes.replace({}, {}));
find("pin").addEventListener("click", () => player.recording && comparedMotions.pin());
find("by-hand").addEventListener("click", () => player.clock.set({ frame: 0, playing: false }));
if (location.hash) takeAddress();
changes.onChange(() => {
  notice = "";
});
let [known, inputSteps] = [hashOf(changes), null]; // the parameters, and the dragged handle, at the last change
changes.onChange(() => {
  const now = hashOf(changes);
  if (now !== known) comparedMotions.change(handles.dragged !== null && handles.dragged === inputSteps);
  [known, inputSteps] = [now, handles.dragged];
});
changes.onChange(remember);
changes.onChange(update);
addEventListener("hashchange", takeAddress);
say();
update();
