// A motion to be shown: what a `Recording` is made of, from two runs. The first finds the impacts, the second has rows at
// the frames, which are close in time where it is shown slowly. Rows do not change the solution.

import { rowTimes } from "./kernel.js";
import { frameTimes, slowSpans } from "./pacing.js";
import { viewOf, wallsAt } from "./view.js";

const IMPACT_TIME = 0.6; // s on the screen that an impact takes
const LONGEST_IMPACT = 5; // of penetration over approach speed
const SLOWEST = 1e-6; // m/s
const PARTS = 100; // of the first run, between which it can be stopped
const NUMBERS = 2_000_000; // coordinates at most
const FEWEST = 200; // frames
const MOST = 20_000;
const ALONE = 1e-3; // of the size of the motion: a smaller radius is not drawn
const ENERGIES = ["kinetic", "potential", "elastic", "dissipated", "friction", "supplied", "total"];
const STOPS = ["joint_min", "joint_max"];

/** The impacts as the page lists them, of those that the kernel found until some time. */
function listed(impacts, scene, valueOf, stop) {
  return impacts.map(({ point, wall, onset, end, impact_speed: speed, max_penetration: depth, peak_force: peak }) => {
    const name = scene.wallNames[wall];
    const atStop = scene.stops.length > 0 && STOPS.includes(name);
    const until = Number.isFinite(end) ? end : stop;
    const lasting = (LONGEST_IMPACT * depth) / Math.max(speed, SLOWEST);
    return {
      point,
      wall: name,
      onset,
      end: until,
      impactEnd: Math.min(until, onset + lasting),
      speed,
      endSpeed: speed * (atStop ? valueOf(`link[${point}].length`) : 1),
      peak: peak > 0 ? peak : null,
      resolved: true,
      atStop,
    };
  });
}

/** First and last frame of each span in which numbers are above zero. */
function spansOf(values) {
  const spans = [];
  values.forEach((value, frame) => {
    if (!(value > 0)) return;
    if (spans.length && spans.at(-1)[1] === frame - 1) spans.at(-1)[1] = frame;
    else spans.push([frame, frame]);
  });
  return spans;
}

const isSome = (values) => values.some((value) => value > 0);

/** The forces at walls and the moments at stops that are not zero all the time. */
function forcesOf(columns) {
  const found = [];
  for (const [name, values] of Object.entries(columns)) {
    const [, point, wall] = /^contact\[(\d+)\]\.(\w+)\.force$/.exec(name) ?? [];
    if (wall && isSome(values)) {
      const [friction, sticking] = ["friction_force", "sticking"].map((key) => columns[`contact[${point}].${wall}.${key}`]);
      found.push({ point: Number(point), wall, values, friction, spans: sticking ? spansOf(sticking) : [] });
    }
    const [, joint] = /^joint\[(\d+)\]\.stop_moment$/.exec(name) ?? [];
    if (joint) {
      [1, -1].forEach((sign, k) => {
        const moment = values.map((value) => Math.max(sign * value, 0));
        if (isSome(moment)) found.push({ point: Number(joint), wall: STOPS[k], values: moment, spans: [] });
      });
    }
  }
  return found;
}

function stuckJointsOf(columns) {
  return Object.entries(columns).flatMap(([name, values]) => {
    const [, joint] = /^joint\[(\d+)\]\.sticking$/.exec(name) ?? [];
    return joint ? [{ joint: Number(joint), spans: spansOf(values) }] : [];
  });
}

/** The ranges of the joints with stops, as they are drawn. */
function rangesOf(scene, valueOf) {
  return scene.stops.map((joint) => {
    const [low, high] = STOPS.map((stop) => valueOf(`link[${joint}].${stop}`));
    const from = low ?? high - scene.openArc;
    const to = Math.min(high ?? low + scene.openArc, from + 2 * Math.PI);
    return { joint, arc: [from, to], marks: [low, high].filter((end) => end !== undefined) };
  });
}

/** The points in rows of all points. */
function interleaved(columns, links, axis) {
  const each = Array.from({ length: links + 1 }, (_, point) => columns[`point[${point}].${axis}`]);
  const found = new Float64Array(each[0].length * each.length);
  each.forEach((column, point) => column.forEach((value, row) => {
    found[row * each.length + point] = value;
  }));
  return found;
}

/** What a `Recording` is made of, and how the runs ended; it yields the share that is done. */
export function* motion(kernel, values) {
  const { scene } = kernel;
  const valueOf = (name) => {
    const parameter = kernel.parameters.get(name);
    return parameter && (values[name] ?? parameter.start);
  };
  const stop = valueOf("simulation.stop_time");
  const began = performance.now();
  const first = yield* half(kernel.run(values, rowTimes(stop, stop / PARTS), [], 1), 0);
  const spent = performance.now() - began;
  const end = first.status === 0 ? stop : Math.min(first.reached, stop);
  const { status, reached, statistics, impacts } = first;
  const ending = { status, reached, statistics, impacts, spent };
  if (first.time.length === 0 || !(end > 0)) return { ...ending, parts: null };
  const contacts = listed(impacts.filter(({ onset }) => onset <= end), scene, valueOf, end);
  const most = Math.min(MOST, Math.max(FEWEST, Math.floor(NUMBERS / (2 * (scene.links + 1)))));
  const { times, frameRate } = frameTimes(0, end, slowSpans(contacts), IMPACT_TIME, most);
  const names = Object.keys(scene.drawn);
  const second = yield* half(kernel.run(values, times, names.map((name) => ({ word: scene.drawn[name] }))), 0.5);
  if (second.time.length < 2) return { ...ending, parts: null };
  const columns = Object.fromEntries(names.map((name, k) => [name, second.columns[k]]));
  return { ...ending, parts: partsOf(scene, valueOf, second.time, frameRate, columns, contacts) };
}

function* half(run, from) {
  let step = run.next();
  while (!step.done) {
    yield from + step.value / 2;
    step = run.next();
  }
  return step.value;
}

function partsOf(scene, valueOf, time, frameRate, columns, contacts) {
  const [x, y] = ["x", "y"].map((axis) => interleaved(columns, scene.links, axis));
  const walls = wallsAt(scene, valueOf);
  const given = valueOf("contact.radius") ?? 0;
  const reach = viewOf(x, y, scene.links + 1, {}, 0, false).view;
  const radius = given > ALONE * Math.max(reach[1][0] - reach[0][0], reach[1][1] - reach[0][1]) ? given : 0;
  const forces = forcesOf(columns);
  const energies = ENERGIES.map((name) => [name, columns[`energy.${name}`]])
    .filter(([, column]) => column?.some((value) => value !== 0));
  const peaks = contacts.filter(({ peak, atStop }) => peak !== null && !atStop).map(({ peak }) => peak);
  return {
    name: scene.name,
    links: scene.links,
    time,
    frameRate,
    x,
    y,
    energies: Object.fromEntries(energies),
    forces,
    stuckJoints: stuckJointsOf(columns),
    peakForce: Math.max(largest(peaks), ...forces.filter(({ wall }) => wall in walls).map(({ values }) => largest(values)), 1e-300),
    contacts,
    walls,
    stops: rangesOf(scene, valueOf),
    radius,
    touching: scene.contactPoints,
    ...viewOf(x, y, scene.links + 1, walls, radius, scene.pinned),
  };
}

function largest(values) {
  return values.reduce((most, value) => Math.max(most, value), 0);
}
