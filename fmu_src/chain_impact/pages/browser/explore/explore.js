// The program of the page that simulates: each change of a parameter gives another motion. All modules of a page become one script
// (assembly.py), so no two modules may have the same name at the top level.

import { decompressed } from "../base/base64.js";
import { byId, make } from "../base/dom.js";
import { numberText } from "../base/format.js";
import { Player } from "../player/player.js";
import { Recording } from "../recording/recording.js";
import { Changes } from "../scene/changes.js";
import { pageScene } from "../scene/page_scene.js";
import { completedFile } from "../scene/scene_file.js";
import { Address } from "./address.js";
import { ComparedMotions } from "./compared_motions.js";
import { consoleInterface } from "./console.js";
import { CurveChoice } from "./curve_choice.js";
import { Editor } from "./editor.js";
import { connectExport } from "./export_dialog.js";
import { showFirstSteps } from "./first_steps.js";
import { foldEnergiesWithoutRoom } from "./folded_energies.js";
import { Handles } from "./handles.js";
import { UndoHistory } from "./history.js";
import { addJumps, foldParameters } from "./jumps.js";
import { GridMap } from "./map/map.js";
import { OpenScene } from "./open_scene.js";
import { outcomeBeside } from "./parameters/outcome.js";
import { showParameterList } from "./parameters/parameter_list.js";
import { showMainParameters } from "./parameters/sliders.js";
import { RefusedStart } from "./refused_start.js";
import { fillMap } from "./saved_page.js";
import { Simulation } from "./simulation.js";

// The present view stays if the next view lies inside it and is larger than this fraction of it; the size of a view is its longer side.
const KEPT = 0.5;
const SPEED_BAR = 50; // [pixels] largest length of the bar that is the scale of the arrows of velocities
const FILES_OF_RUN = ["csv", "impacts-csv", "png", "charts-png", "charts-svg"]; // buttons that save what only a run has

const { file, kit, command } = JSON.parse(new TextDecoder().decode(await decompressed(byId("data").textContent)));
const changes = new Changes(pageScene(kit, completedFile(file, kit), command));
const player = new Player(1);
const comparedMotions = new ComparedMotions(player, byId("pins"), byId("pin-table"));
const handles = new Handles(player, changes, byId("scene"));
const dragLine = make("p", { className: "by-hand-line" }); // tells in the drawing what the reader can drag
byId("view").append(dragLine);
const [speedBar, speedWords] = [make("span", { className: "speed-bar" }), make("span")];
const showByHand = () => {
  byId("by-hand").setAttribute("aria-pressed", handles.areShown);
  dragLine.hidden = !handles.areShown;
  if (dragLine.hidden || !player.recording) return;
  handles.footWidth = dragLine.offsetWidth;
  // a bar for a speed of 1, 2 or 5 times a power of ten, at most SPEED_BAR long
  const power = 10 ** Math.floor(Math.log10(SPEED_BAR / handles.arrowScale));
  const speed = [5, 2, 1].map((factor) => factor * power).find((one) => one * handles.arrowScale <= SPEED_BAR) ?? power;
  speedBar.style.width = `${speed * handles.arrowScale}px`;
  speedWords.textContent = `${numberText(Number(speed.toPrecision(1)))}\u202fm/s`;
};
const refusedStart = new RefusedStart(player.drawing);
// the line comes before the handles, which keep off it, and the refused start after them, because they clear what it adds to them
player.layers.push(comparedMotions, { draw: showByHand }, handles, refusedStart);

/**
 * Return the parts of the next motion with two views. `ownView` contains this motion alone, `view` also the compared motions of scenes with
 * the same name. In two cases the present view stays as `view`, so that the picture does not move: while a handle is dragged; and if the
 * new view lies inside the present view and is not much smaller (KEPT).
 */
function withSteadyView(next) {
  const ownView = next.view;
  const views = [ownView, ...comparedMotions.behind.filter(({ name }) => name === next.name).map((recording) => recording.ownView)];
  const view = [Math.min, Math.max].map((outer, end) => [0, 1].map((axis) => outer(...views.map((one) => one[end][axis]))));
  const before = player.recording;
  const size = ([low, high]) => Math.max(high[0] - low[0], high[1] - low[1]);
  const isWithin = before && [0, 1].every((axis) => view[0][axis] >= before.view[0][axis] && view[1][axis] <= before.view[1][axis]);
  const isKept = handles.dragged !== null; // while a handle is dragged, the view stays, so that the handle stays below the pointer
  return isKept || (isWithin && size(view) > KEPT * size(before.view))
    ? { ...next, ownView, view: before.view, anchor: before.anchor } : { ...next, ownView, view };
}

// the engine (the worker with a kernel) that begin.js has started, or a new one
const beginEngine = () => (window.begun.engines.pop() ?? window.begun.startEngine()).open(changes.scene);
const choice = new CurveChoice(changes);
const showOutcome = outcomeBeside(byId("main-parameters"));
const simulation = new Simulation(beginEngine, changes, choice, (parts, about, overlap) => {
  document.querySelector("footer").inert = !parts && Boolean(player.recording);
  FILES_OF_RUN.forEach((id) => Object.assign(byId(id), { disabled: !parts }));
  refusedStart.show(overlap, player, Boolean(parts), handles.dragged);
  if (parts) {
    player.show(Object.assign(new Recording(withSteadyView(parts)), about));
    comparedMotions.show();
    choice.bringIntoView();
    if (about.values === changes.values) bringBack(address.takeAwaited()); // else the link is newer than the run
    simulation.addCurves(comparedMotions.pins).then((isNew) => isNew && comparedMotions.show());
  } else if (player.recording) {
    comparedMotions.show();
  }
  showOutcome(parts ? player.recording : undefined);
  editor.tellRun(Boolean(parts));
  window.begun.finishLoad(player.clock.playing);
});
/** Go to the `time` and pin the motions `pins` of a link; what the link lacks is undefined. A new run then fits the view to all pins. */
function bringBack({ pins, time }) {
  if (time !== undefined) player.clock.set({ playing: false, frame: player.recording.frameAt(time) });
  if (!pins) return;
  simulation.motionsOf(pins).then((motions) => {
    comparedMotions.pinAll(motions);
    if (motions.length) simulation.soon();
  });
}

const openScene = new OpenScene(changes, choice, kit);
const editor = new Editor(changes, openScene, kit.keys);
changes.onChange(() => {
  byId("reset-all").hidden = changes.count === 0 && !openScene.isEdited;
});
const presentState = () =>
  ({ isPlaying: player.clock.playing, time: player.recording ? player.clock.time : 0, inputs: player.recording?.inputs });
player.layers.push({ draw: showMainParameters(byId("main-parameters"), changes, presentState) });
showParameterList(byId("list-of-parameters"), changes, kit.keys);
const { clock } = player;
const address = new Address(changes, choice, { openScene, clock, comparedMotions, refuse: (fault) => simulation.notify(fault) });
comparedMotions.follow(changes, handles);
const steps = new UndoHistory(changes, openScene, handles, () => editor.refresh());
choice.onChange(() => {
  address.updateSoon();
  steps.keepOutputs();
  simulation.soon();
});

let map; // made when the reader opens it; it has engines of its own, so that it does not delay the motion
const ask = (...request) => simulation.engine.ask(...request);
window.chainImpact = consoleInterface(changes, ask);
connectExport(changes, {
  keys: kit.keys, ask, address, openScene,
  linesBelow: () => comparedMotions.caption, mapNow: () => map, faultOf: (...end) => simulation.faultOf(...end),
});
// a press on a point or its number proposes its outputs for charts; at the start, a press is for a handle
byId("scene").addEventListener("click", ({ target }) => {
  const { recording, drawing: { dots, names } } = player;
  if (!recording || handles.areShown) return;
  const point = dots.find(([, dot]) => dot.node === target)?.[0] ?? names.findIndex(({ node }) => node === target);
  if (point >= 0) choice.open(`point ${point}`);
});
byId("map-open").addEventListener("click", () => {
  if (!map) {
    map = new GridMap(beginEngine, changes);
    fillMap(map);
  }
  map.open();
});
byId("reset-all").addEventListener("click", () => (changes.count ? changes.replace({}, {}) : openScene.undoEdits()));
byId("pin").addEventListener("click", () => player.recording && comparedMotions.pin());
byId("by-hand").addEventListener("click", ({ detail }) => {
  player.clock.set({ frame: 0, playing: false });
  if (detail > 0 || !player.recording) return;
  // a key has pressed the button, so the arrow keys are to move the first handle next
  player.draw();
  byId("scene").querySelector("[data-grip^=joint]").focus({ preventScroll: true });
});
/** Tell by the button what the reader can drag at the start: walls only if the scene has any. */
const tellByHand = () => {
  const hasWalls = Object.keys(changes.scene.walls).length > 0;
  const dragged = hasWalls ? "joints, velocities, and walls" : "joints and velocities";
  byId("by-hand").title = byId("by-hand-text").textContent = `At the start, drag ${dragged}. Playing ends this.`;
  const otherwise = make("span", { className: "wide", textContent: "; or use Tab, Page Down, arrow keys" });
  dragLine.replaceChildren(`Drag ${dragged.replace("velocities", "velocities (green dots)")}`, otherwise, speedBar, speedWords);
};
changes.onOpen(tellByHand);
tellByHand();
showFirstSteps(changes);
addJumps();
foldParameters();
foldEnergiesWithoutRoom(changes);
simulation.begin();
window.begun.beginProgram();
