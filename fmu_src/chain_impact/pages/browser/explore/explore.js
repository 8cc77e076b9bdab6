// The page that simulates: each change of a parameter gives another motion.

import { decompressed } from "../base/base64.js";
import { find, make } from "../base/dom.js";
import { readable } from "../base/format.js";
import { Player } from "../player/player.js";
import { Recording } from "../recording/recording.js";
import { tomlText } from "../scene/changed_file.js";
import { Changes } from "../scene/changes.js";
import { inputStepsIn, inputStepTexts } from "../scene/input_steps.js";
import { describe } from "../scene/model.js";
import { asWritten, complete, contentsIn } from "../scene/scene_file.js";
import { inputText } from "../scene/words.js";
import { Engine } from "../solver/engine.js";
import { ComparedMotions } from "./compared_motions.js";
import { consoleInterface, faultText, stopText } from "./console.js";
import { CurveChoice } from "./curve_choice.js";
import { editedScene } from "./edited_scene.js";
import { Editor } from "./editor.js";
import { changesIn, hashOf } from "./export.js";
import { connectExport } from "./export_dialog.js";
import { Handles } from "./handles.js";
import { GridMap } from "./map/map.js";
import { showParameterList } from "./parameters/parameter_list.js";
import { showMainParameters } from "./parameters/sliders.js";

const WAITING = 120; // [ms] the computing time after which the old motion becomes pale
const PATIENCE = 250; // [ms] the time that a run has before the next change ends it: so a slider shows its effect while it is dragged
const REST = 300; // [ms] the time without a change after which the address gets the changes
// The present view stays if the next view lies inside it and is larger than this fraction of it; the size of a view is the larger of
// its width and height.
const KEPT = 0.5;

const { file, kit, command, module: packedModule } = JSON.parse(find("data").textContent);
const pageScene = describe(kit, complete(file, kit), command);
const changes = new Changes(pageScene);
const needed = ["Worker", "WebAssembly", "DecompressionStream"].filter((name) => !(name in window));
if (needed.length) throw new Error(`this browser has no ${needed.join(", no ")}`);
const module = decompressed(packedModule).then((bytes) => WebAssembly.compile(bytes));
const program = URL.createObjectURL(new Blob([find("worker").textContent], { type: "text/javascript" }));
const startEngine = () => new Engine(program, changes.scene, module);
let engine = startEngine();
let opened = ""; // the text of the open scene file; empty for the page's own scene
const player = new Player(1);
const comparedMotions = new ComparedMotions(player, find("pins"), find("pin-table"));
const handles = new Handles(player, changes, find("scene"));
player.layers.push(comparedMotions, handles);
const choice = new CurveChoice(changes, () => {
  updateAddressSoon();
  simulateSoon();
});

/**
 * Return the parts of the next motion, with `view`, which holds this motion and the motions behind it of scenes with its name,
 * and `ownView`, which holds this motion alone. The present view stays, so that the picture does not move, if the next one lies
 * inside it and is not much smaller (KEPT), or while a handle is dragged.
 */
function withSteadyView(next) {
  const ownView = next.view;
  const views = [ownView, ...comparedMotions.behind.filter(({ name }) => name === next.name).map((recording) => recording.ownView)];
  const view = [Math.min, Math.max].map((outer, end) => [0, 1].map((axis) => outer(...views.map((one) => one[end][axis]))));
  const before = player.recording;
  const size = ([low, high]) => Math.max(high[0] - low[0], high[1] - low[1]);
  const isWithin = before && [0, 1].every((axis) => view[0][axis] >= before.view[0][axis] && view[1][axis] <= before.view[1][axis]);
  const isKept = handles.dragged !== null; // a handle that is dragged stays below the pointer
  return isKept || (isWithin && size(view) > KEPT * size(before.view))
    ? { ...next, ownView, view: before.view, anchor: before.anchor } : { ...next, ownView, view };
}

/** Return a sentence on the fault of a run; "" without a fault. `hasMotion`: whether there is a motion. */
function sentenceOf(run, hasMotion) {
  if (run.status === 0) return "";
  return hasMotion ? `The simulation ${stopText(run, changes.scene)}.` : `The simulation cannot start: ${faultText(run, changes.scene)}.`;
}

let addressTimer; // the timer of `updateAddressSoon`
let sentence = ""; // the sentence on the end of the last simulation
let ending = 0; // the status of the last simulation
let notice = ""; // a sentence on a fault in the address, until something changes

function showStatus(next = sentence) {
  sentence = next;
  const all = [notice, sentence].filter(Boolean).join(" ");
  find("status").classList.add("begun");
  find("status").textContent = readable(all);
  find("status").hidden = !all;
  if (ending === SHARED.kernel.FRICTION_WITH_RIGID_WALLS) find("status").append(" ", withoutFriction());
}

/** Return a button that sets all friction of walls to zero, for a law that does not allow friction. */
function withoutFriction() {
  const button = make("button", { type: "button", className: "action", textContent: "Set the friction of walls to 0" });
  const ofWalls = ({ filePath }) => filePath?.[0] === "contact" && filePath.at(-1).endsWith("friction");
  const names = [...changes.parameters.values()].filter(ofWalls).map(({ name }) => name);
  button.addEventListener("click", () => changes.set(Object.fromEntries(names.map((name) => [name, 0]))));
  return button;
}

let [started, nextRun] = [-Infinity, 0]; // when the present run began, and the timer of the next one

/** Simulate with the present parameters, as soon as the present run has ended or has taken PATIENCE. */
function simulateSoon() {
  clearTimeout(nextRun);
  const left = started + PATIENCE - performance.now();
  if (left > 0) nextRun = setTimeout(simulateNow, left);
  else simulateNow();
}

/** Simulate with the present parameters, and show the motion, unless a newer run has replaced this one. */
async function simulateNow() {
  [started, nextRun] = [performance.now(), 0];
  find("reset-all").hidden = changes.count === 0;
  const { scene } = changes;
  const text = [...changes.texts(), ...inputStepTexts(changes)].map(([name, value]) => `${name} = ${value}`).join(", ");
  const waiting = setTimeout(() => document.body.classList.add("computing"), WAITING);
  const result = await engine
    .ask("motion", changes.values, { replaces: true, curves: choice.names, inputSteps: changes.inputSteps }, (share) =>
      find("stage").style.setProperty("--share", `${100 * share}%`))
    .catch((error) => ({ parts: null, fault: `The solver cannot work in this browser: ${error.message}.` }));
  clearTimeout(waiting);
  if (!result) return;
  started = -Infinity;
  document.body.classList.remove("computing");
  document.body.classList.toggle("stale", !result.parts);
  ending = result.status;
  showStatus(result.fault ?? sentenceOf(result, result.parts));
  if (result.parts) {
    player.show(Object.assign(new Recording(withSteadyView(result.parts)), { text, scene }));
    comparedMotions.show();
  } else if (player.recording) {
    player.drawSoon();
  }
  if (nextRun) simulateSoon();
}

/** Return the address of the page with the open scene, the changes and the chosen outputs. */
function address() {
  const hash = hashOf(changes, { scene: opened, curves: choice.names.join() });
  return location.href.split("#")[0] + (hash && `#${hash}`);
}

/** Put the changes into the address after a time without changes, because browsers limit how often an address may change. */
function updateAddressSoon() {
  clearTimeout(addressTimer);
  addressTimer = setTimeout(() => history.replaceState(null, "", address()), REST);
}

/** Show another scene and its name; `text` is the text of its file, empty for the page's own scene; `kept` are changes in it. */
function showScene(scene, text, kept) {
  opened = text;
  engine.end();
  changes.open(scene, kept);
  showDescription();
}

/** Open a scene with the contents of a file; an error says which key is wrong. */
function openContents(contents) {
  openFile(sceneIn(contents));
}

/**
 * Open contents edited from those of the present scene, with the reader's changes and chosen outputs; an error says which key is
 * wrong. `before`: the parts before the edit.
 */
function openEdited(contents, before) {
  const { nameOf, kept, ...edited } = editedScene(contents, before, changes, { kit, open: sceneIn });
  choice.names = choice.names.map(nameOf).filter(Boolean);
  openFile(edited, kept);
}

/** Return the complete file of some contents and its scene; commands call the file by the name of the scene. */
function sceneIn(contents) {
  const whole = complete(contents, kit);
  return { whole, scene: describe(kit, whole, [`${whole.name}.toml`]) };
}

function openFile({ whole, scene }, kept) {
  showScene(scene, tomlText(asWritten(whole), kit.keys), kept);
}

/** Show name and description of the scene, and notes on its inputs: when sliders act, and which inputs are constant here. */
function showDescription() {
  const { name, text, still, inputs } = changes.scene;
  document.querySelector("h1").textContent = name;
  document.title = `${name} – chain-impact`;
  find("description").textContent = text;
  find("description").hidden = !text;
  const notes = [
    inputs.length && "While the motion plays, the slider of an input acts from that moment on.",
    still.length && `These inputs keep their start values here: ${still.map(inputText).join("; ")}.`,
  ].filter(Boolean);
  find("inputs").hidden = notes.length === 0;
  find("inputs").textContent = notes.join(" ");
  find("edit-first").hidden = !opened;
}

/**
 * Use the scene and the changes in the address; a fault is shown. A fault in the scene changes nothing; with a fault in the
 * changes, all changes of the address are left out.
 */
function applyAddress() {
  try {
    const { scene: text = "", curves = "", ...parts } = changesIn(location.hash);
    if (text !== opened) {
      if (text) openContents(contentsIn(text));
      else showScene(pageScene, "");
    }
    const { others, inputSteps } = inputStepsIn(parts, changes);
    const values = new Changes(changes.scene).with(others);
    choice.take(curves);
    changes.replace(values, inputSteps);
  } catch (error) {
    notice = `The link cannot be used: ${error.message}.`;
    updateAddressSoon();
    showStatus();
  }
}

const ask = (...request) => engine.ask(...request);
window.chainImpact = consoleInterface(changes, ask);

let grid; // the map is made when it is first opened; it has other workers than the motion
find("map-open").addEventListener("click", () => {
  grid ??= new GridMap(startEngine, changes);
  grid.open();
});
changes.onOpen(() => {
  engine = startEngine();
});
new Editor(changes, { openContents, openEdited, openFirst: () => showScene(pageScene, "") }, kit.keys);
showDescription();
const presentTime = () => ({ isPlaying: player.clock.playing, time: player.recording ? player.clock.time : 0 });
player.layers.push({ draw: showMainParameters(find("main-parameters"), changes, presentTime) });
showParameterList(find("list-of-parameters"), changes);
connectExport(changes, { keys: kit.keys, ask, address, isOpened: () => opened !== "", faultOf: sentenceOf });
find("reset-all").addEventListener("click", () => changes.replace({}, {}));
find("pin").addEventListener("click", () => player.recording && comparedMotions.pin());
find("by-hand").addEventListener("click", () => player.clock.set({ frame: 0, playing: false }));
if (location.hash) applyAddress();
changes.onChange(() => {
  notice = "";
});
let [lastHash, lastDragged] = [hashOf(changes), null]; // the parameters, and the dragged handle, at the last change
changes.onChange(() => {
  const hash = hashOf(changes);
  if (hash !== lastHash) comparedMotions.change(handles.dragged !== null && handles.dragged === lastDragged);
  [lastHash, lastDragged] = [hash, handles.dragged];
});
changes.onChange(updateAddressSoon);
changes.onChange(simulateSoon);
addEventListener("hashchange", applyAddress);
showStatus();
find("caption").textContent = "Simulating…"; // until the first motion is drawn
simulateSoon();
