// The page: its parts, and the loop that draws them.

import { EnergyChart, ForceChart } from "./charts.js";
import { Clock } from "./clock.js";
import { connect } from "./controls.js";
import { rateText } from "./format.js";
import { ImpactList, impactText } from "./impacts.js";
import { Recording } from "./recording.js";
import { Scene } from "./scene.js";

const LONGEST_FRAME = 0.1; // s: after a pause of the browser, the animation goes on where it was
const SLOW = 0.5; // of the chosen speed: below, the clock says that this is slow motion
const element = (id) => document.getElementById(id);

const recording = new Recording(JSON.parse(element("data").textContent));
const clock = new Clock(recording);
const scene = new Scene(element("scene"), recording);
const parts = [scene];
/** Add a part, or without what it shows, take its panel away. */
function addPart(isThere, panel, make) {
  if (isThere) parts.push(make());
  else element(panel).closest("section").remove();
}
addPart(Object.keys(recording.energies).length > 0, "energy", () =>
  new EnergyChart(element("energy"), element("ledger"), recording, (time) => clock.seek(time)));
addPart(recording.forces.length > 0, "force", () =>
  new ForceChart(element("force"), recording, element("close-what")));
parts.push(new ImpactList(element("impacts"), recording, (number) => clock.toImpact(number)));

const count = recording.impacts.length;
element("subtitle").textContent =
  `${recording.links} link${recording.links === 1 ? "" : "s"}, ` +
  `${count} impact${count === 1 ? "" : "s"} in ${+(recording.end - recording.start).toPrecision(4)} s`;

/** The clock in words, the caption, and every part, at the present frame. */
function draw() {
  const { frame, time, contact } = clock;
  parts.forEach((part) => part.draw(frame, contact));
  element("time").textContent = `${time.toFixed(5)} s`;
  const slow = clock.slow && recording.rateAt(frame) < SLOW;
  element("rate").textContent = rateText(clock.rate);
  document.body.classList.toggle("slow-motion", slow);
  document.body.classList.toggle("playing", clock.playing);
  const caption = impactText(recording, contact, time);
  if (element("caption").textContent !== caption) element("caption").textContent = caption;
}

let asked = false;
/** Draw before the browser paints next, once. */
function drawSoon() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    draw();
  });
}

let before;
function tick(now) {
  if (clock.playing && before !== undefined) clock.advance(Math.min((now - before) / 1000, LONGEST_FRAME));
  before = now;
  requestAnimationFrame(tick);
}

function fit() {
  const { clientWidth, clientHeight } = element("view");
  scene.resize(clientWidth, clientHeight);
  drawSoon();
}

const [low, high] = recording.view;
element("view").style.setProperty("--aspect", (high[0] - low[0]) / (high[1] - low[1]));
connect(clock, scene);
clock.onChange(drawSoon);
new ResizeObserver(fit).observe(element("view"));
fit();
draw();
performance.mark("first-frame");
clock.set({ playing: !matchMedia("(prefers-reduced-motion: reduce)").matches });
requestAnimationFrame(tick);
